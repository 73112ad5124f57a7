#include "clay/clay.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "clay/clay_state.h"

namespace tactile_clay::clay {
namespace {

void require(bool ok, const std::string& what, double value, const std::string& expected) {
  if (!ok)
    throw std::invalid_argument("clay: " + what + " is " + std::to_string(value) + ", expected " + expected);
}

}  // namespace

void validate(const ClayConfig& c) {
  require(c.spacing > 0.0 && c.spacing <= 1.0, "spacing", c.spacing, "0 < spacing <= 1 m");
  require(c.frame > 0.0 && c.frame <= 1.0, "frame", c.frame, "0 < frame <= 1 s");
  require(c.budget.substeps >= 1, "substeps", c.budget.substeps, ">= 1");
  require(c.budget.iterations >= 1, "iterations", c.budget.iterations, ">= 1");
  require(c.gravity.allFinite(), "gravity", c.gravity.norm(), "finite numbers");
  require(c.world > 0.0, "world", c.world, "> 0 m");
  require(c.tolerance >= 0.0, "tolerance", c.tolerance, ">= 0 m/s^2");
  require(c.threads >= 0, "threads", c.threads, ">= 0");
}

void validate(const Material& m) {
  const std::string of = " of material '" + m.name + "'";
  for (const Coefficient& c : coefficients) {
    const double value = m.*c.value;
    require((c.open ? value > c.low : value >= c.low) && value <= c.high, c.name + of, value, c.range);
  }
  require(m.unbond_rate >= m.bond_rate, "unbond_rate" + of, m.unbond_rate, ">= bond_rate");
}

std::size_t maxSkinSamples(double spacing) {
  return static_cast<std::size_t>(std::clamp(1.0 / (spacing * spacing), 20e3, 250e3));
}

Method methodNamed(const std::string& name) {
  if (name == "minimise") return Method::minimise;
  if (name == "paper") return Method::paper;
  throw std::invalid_argument("solver '" + name + "', expected minimise or paper");
}

Clay::Clay(const ClayConfig& config, std::vector<Material> materials,
           std::vector<InitialParticle> particles) {
  validate(config);
  if (materials.empty()) throw std::invalid_argument("clay: no material given, expected at least one");
  for (const Material& m : materials) validate(m);
  state_ = std::make_unique<State>(config, std::move(materials), particles);
}

Clay::~Clay() = default;

void Clay::advance(const Skin& skin, const std::vector<Solid>& solids, double duration) {
  const auto steadily = [&](double t, std::vector<Eigen::Isometry3d>& poses) {
    poses.clear();
    for (const Solid& solid : solids) poses.push_back(poseAfter(solid, t - state_->time));
  };
  advance(skin, solids, std::cref(steadily), duration);
}

void Clay::advance(const Skin& skin, const std::vector<Solid>& solids, const SolidMotion& motion,
                   double duration) {
  State& s = *state_;
  require(skin.size() <= maxSkinSamples(s.config.spacing), "number of samples",
          static_cast<double>(skin.size()),
          "at most " + std::to_string(maxSkinSamples(s.config.spacing)) + " at this spacing");
  require(skin.normal.size() == skin.size() && skin.velocity.size() == skin.size(), "number of samples",
          static_cast<double>(skin.size()), "as many normals and velocities");
  const double dt = s.config.timeStep();
  s.carry += duration;
  const int steps = std::max(static_cast<int>(std::lround(s.carry / dt)), 0);
  s.carry -= steps * dt;
  s.beginFrame(skin, solids.size(), steps);
  if (steps == 0) return;
  s.posesAt(motion, s.time, solids.size());
  s.team.execute([&] {
    for (int k = 0; k < steps; ++k) {
      s.moveSamples(static_cast<float>((steps - 1 - k) * dt));
      s.start_poses.swap(s.end_poses);
      s.posesAt(motion, s.time + (k + 1) * dt, solids.size());
      const Surroundings around = s.surroundings(solids);
      if (s.sleeps() && s.sleep.wake(s.everyone, s.particles, around)) s.regroup();
      s.step(around);
      s.collectForces(steps, static_cast<float>(dt));
    }
    s.particles.density_ratio =
        s.config.budget.method == Method::paper ? s.projection.densityRatio() : s.minimiser.densityRatio();
    s.publishAwake();
  });
  s.time += steps * dt;
  s.endFrame(steps);
  if (s.sleeps() && s.sleep.settle(s.particles, s.near, s.surroundings(solids), steps * dt)) s.regroup();
}

Sculpture Clay::sculpture() const {
  return state_->sculpture();
}

void Clay::restore(const Sculpture& sculpture) {
  State& s = *state_;
  if (sculpture.material.size() != s.everyone.size()) {
    throw std::invalid_argument("the sculpture has " + std::to_string(sculpture.material.size()) +
                                " particles, expected " + std::to_string(s.everyone.size()));
  }
  if (sculpture.material != s.everyone.material || sculpture.body != s.everyone.body)
    throw std::invalid_argument("the sculpture's bodies or materials are not those of the scene");
  require(sculpture.spacing == s.config.spacing, "the sculpture's spacing", sculpture.spacing,
          std::to_string(s.config.spacing) + " m");
  s.restore(s.sleeps() ? sculpture : woken(sculpture));
}

const ClayConfig& Clay::config() const {
  return state_->config;
}
const std::vector<Material>& Clay::materials() const {
  return state_->materials;
}
const Particles& Clay::particles() const {
  return state_->everyone;
}
double Clay::time() const {
  return state_->time;
}
const std::vector<SkinForce>& Clay::skinForces() const {
  return state_->skin_forces;
}
const std::vector<Eigen::Vector3d>& Clay::solidForces() const {
  return state_->solid_forces;
}
const Statistics& Clay::statistics() const {
  return state_->statistics;
}

}  // namespace tactile_clay::clay
