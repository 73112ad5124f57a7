#include "clay/clay_state.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace tactile_clay::clay {

Clay::State::State(const ClayConfig& config_in, std::vector<Material> materials_in,
                   const std::vector<InitialParticle>& initial)
    : config(config_in),
      materials(std::move(materials_in)),
      team(config.threads),
      kernel(static_cast<float>(2.0 * config.spacing)),
      near(kernel.h),
      minimiser(kernel, config.spacing, materials),
      projection(kernel, static_cast<float>(config.spacing), materials),
      bond_constraint(static_cast<float>(config.spacing), materials),
      contact_constraint(static_cast<float>(config.spacing), materials),
      sleep(static_cast<float>(config.spacing), crumb_size) {
  takeParticles(initial);
  setWalls();
  for (const Material& m : materials) bonded = bonded || m.stiffness > 0.0;
  Sculpture start;
  start.spacing = config.spacing;
  start.position = start.window_start = start.sleep.mark = everyone.position;
  start.velocity = everyone.velocity;
  start.compression = everyone.compression;
  start.window_steps = config.budget.substeps;
  start.material = everyone.material;
  start.body = everyone.body;
  start.bond_begin.assign(initial.size() + 1, 0);
  start.sleep.lump.assign(initial.size(), 0);
  restore(start);
  statistics.stages = {{"neighbours"}, {"contact_search"}, {"bonds"}, {"setup"}, {"iterations"}, {"finish"}};
}

/// @throws std::invalid_argument naming the particle
void Clay::State::takeParticles(const std::vector<InitialParticle>& initial) {
  const std::size_t n = initial.size();
  everyone.position.resize(n);
  everyone.velocity.resize(n);
  everyone.density_ratio.assign(n, 1.0f);
  // Density may give back all compression that the clay starts with.
  everyone.compression.assign(n, std::numeric_limits<float>::infinity());
  const double volume = std::pow(config.spacing, 3.0);
  for (std::size_t i = 0; i < n; ++i) {
    if (!initial[i].position.allFinite() || !initial[i].velocity.allFinite()) {
      throw std::invalid_argument("clay: particle " + std::to_string(i) + " is not finite");
    }
    if (initial[i].material >= materials.size()) {
      throw std::invalid_argument("clay: particle " + std::to_string(i) + " has material " +
                                  std::to_string(initial[i].material) + " of " +
                                  std::to_string(materials.size()));
    }
    everyone.position.set(i, initial[i].position);
    everyone.velocity.set(i, initial[i].velocity);
    everyone.inverse_mass.push_back(
        static_cast<float>(1.0 / (materials[initial[i].material].density * volume)));
    everyone.material.push_back(initial[i].material);
    everyone.body.push_back(initial[i].body);
  }
}

void Clay::State::setWalls() {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Solid wall;
      wall.name = "world";
      wall.size.setConstant(2.0 * config.world);
      wall.pose.translation()[axis] = side * (3.0 * config.world + 0.5 * config.spacing);
      walls.push_back(wall);
    }
  }
}

/// A sample that is not finite, is far outside of the world or has no unit normal does not exist. A sample
/// that is faster than any hand has jumped; its velocity is set to zero. Norms are compared because a NaN
/// fails every comparison, while maxCoeff may drop it.
void Clay::State::takeSamples(const Skin& skin) {
  constexpr float fastest = 50.0f;  // m/s
  const float far = static_cast<float>(100.0 * config.world);
  target.position = skin.position;
  target.normal = skin.normal;
  target.velocity = skin.velocity;
  for (std::size_t k = 0; k < target.size(); ++k) {
    const bool unit = std::abs(target.normal[k].squaredNorm() - 1.0f) < 0.1f;
    const bool there = unit && target.position[k].norm() < std::min(far, nowhere);
    if (!there) {
      target.position[k].setConstant(nowhere);
      target.normal[k] = Eigen::Vector3f::UnitZ();
    }
    if (!there || !(target.velocity[k].norm() < fastest)) target.velocity[k].setZero();
  }
  moved = target;
}

/// Moves the samples to the end of the step.
/// @param remaining s, time of the frame after the step
void Clay::State::moveSamples(float remaining) {
  for (std::size_t k = 0; k < target.size(); ++k)
    moved.position[k] = target.position[k] - remaining * target.velocity[k];
}

/// Adds the walls of the world to the solids if any particle may come near them.
/// @param farthest m, largest coordinate of a particle, now or after its free motion
Surroundings Clay::State::withWalls(const Surroundings& around, double farthest) {
  if (!(farthest > config.world - 2.0 * config.spacing)) return around;
  walled = around.solids;
  walled_start = around.start;
  walled_end = around.end;
  for (const Solid& wall : walls) {
    walled.push_back(wall);
    walled_start.push_back(wall.pose);
    walled_end.push_back(wall.pose);
  }
  return {around.skin, walled, walled_start, walled_end, around.dt};
}

/// Sets `end_poses` to the poses at time t, s.
/// @param solids number of solids
void Clay::State::posesAt(const SolidMotion& motion, double t, std::size_t solids) {
  motion(t, end_poses);
  if (end_poses.size() != solids)
    throw std::invalid_argument("clay: " + std::to_string(end_poses.size()) + " poses of " +
                                std::to_string(solids) + " solids, expected one each");
}

Surroundings Clay::State::surroundings(const std::vector<Solid>& solids) const {
  return {moved, solids, start_poses, end_poses, static_cast<float>(config.timeStep())};
}

/// Resets the sums over a frame. If the frame has no step, forces stay, except on samples that are gone.
void Clay::State::beginFrame(const Skin& skin, std::size_t solids, int steps) {
  for (Stage& stage : statistics.stages) stage.ms = 0.0;
  iterations_done = rounds_done = 0;
  statistics.samples_looked_at = 0;
  ++statistics.step;
  if (steps == 0) {
    const auto is_gone = [&](const SkinForce& f) { return f.index >= skin.size(); };
    skin_forces.erase(std::remove_if(skin_forces.begin(), skin_forces.end(), is_gone), skin_forces.end());
    return;
  }
  sample_sums.assign(skin.size(), SampleSum());
  solid_forces.assign(solids, Eigen::Vector3d::Zero());
  takeSamples(skin);
}

/// Sets the statistics and the skin forces of a frame from its steps.
void Clay::State::endFrame(int steps) {
  double error = 0.0, largest = 0.0;
  for (const float ratio : everyone.density_ratio) {
    const double excess = std::max(ratio - 1.0, 0.0);
    error += excess;
    largest = std::max(largest, excess);
  }
  statistics.density_error_mean = everyone.size() ? error / everyone.size() : 0.0;
  statistics.density_error_max = largest;
  statistics.awake = particles.size();
  statistics.iterations = static_cast<double>(iterations_done) / steps;
  statistics.rounds = static_cast<double>(rounds_done) / steps;
  statistics.rejected_displacements = rejected;
  countLumps();
  countStrays();
  statistics.bonds = bond_constraint.size() + sleeping_bonds.size() / 2;
  statistics.contacts = contact_constraint.contacts().size() + sleeping_contacts.size();
  skin_forces.clear();
  for (std::uint32_t k = 0; k < sample_sums.size(); ++k) {
    const SampleSum& sum = sample_sums[k];
    const double slip = sum.pressed > 0.0 ? sum.slip / sum.pressed : 0.0;
    if (sum.touched) skin_forces.push_back({k, sum.force.cast<float>(), static_cast<float>(slip)});
  }
}

/// Counts the lumps of the last step, and those that sleep.
void Clay::State::countLumps() {
  std::vector<std::size_t> sizes(near.lumps(), 0);
  for (std::size_t i = 0; i < particles.size(); ++i) ++sizes[near.lump(i)];
  statistics.lumps = sizes.size() + sleep.lumps();
  statistics.crumbs = static_cast<std::size_t>(
      std::count_if(sizes.begin(), sizes.end(), [](std::size_t size) { return size < crumb_size; }));
}

void Clay::State::countStrays() {
  const float wall = static_cast<float>(config.world - config.spacing);
  statistics.strays = 0;
  for (std::size_t i = 0; i < everyone.size(); ++i)
    statistics.strays += everyone.position.at(i).cwiseAbs().maxCoeff() > wall;
}

}  // namespace tactile_clay::clay
