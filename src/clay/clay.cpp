#include "clay/clay.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "clay/bonds.h"
#include "clay/contacts.h"
#include "clay/kernel.h"
#include "clay/minimiser.h"
#include "clay/neighbourhood.h"
#include "clay/projection.h"
#include "clay/range_sums.h"
#include "clay/sleep.h"
#include "clay/threads.h"

namespace tactile_clay::clay {
namespace {

void require(bool ok, const std::string& what, double value, const std::string& expected) {
  if (!ok)
    throw std::invalid_argument("clay: " + what + " is " + std::to_string(value) + ", expected " + expected);
}

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

/// Adds wall time to a stage.
class Stopwatch {
 public:
  explicit Stopwatch(double& ms) : ms_(ms) {}
  ~Stopwatch() {
    ms_ += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& ms_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

void validate(const Material& m) {
  const std::string of = " of material '" + m.name + "'";
  require(m.density > 0.0, "density" + of, m.density, "> 0 kg/m^3");
  require(m.bulk_modulus >= 0.0, "bulk_modulus" + of, m.bulk_modulus, ">= 0 Pa");
  require(m.viscosity >= 0.0, "viscosity" + of, m.viscosity, ">= 0 Pa s");
  require(m.stiffness >= 0.0, "stiffness" + of, m.stiffness, ">= 0 Pa");
  require(m.bond_rate >= 0.0, "bond_rate" + of, m.bond_rate, ">= 0 1/s");
  require(m.unbond_rate >= m.bond_rate, "unbond_rate" + of, m.unbond_rate, ">= bond_rate");
  require(m.yield_strain > 0.0, "yield_strain" + of, m.yield_strain, "> 0");
  require(m.friction >= 0.0, "friction" + of, m.friction, ">= 0");
  require(m.adhesion >= 0.0, "adhesion" + of, m.adhesion, ">= 0 Pa");
  require(m.skin_friction >= 0.0, "skin_friction" + of, m.skin_friction, ">= 0");
}

Method methodNamed(const std::string& name) {
  if (name == "minimise") return Method::minimise;
  if (name == "paper") return Method::paper;
  throw std::invalid_argument("solver '" + name + "', expected minimise or paper");
}

struct Clay::State {
  enum StageIndex { neighbours, contact_search, bonds, setup, iterations, finish };

  State(const ClayConfig& config_in, std::vector<Material> materials_in,
        const std::vector<InitialParticle>& initial);

  double& ms(StageIndex stage) { return statistics.stages[stage].ms; }
  bool sleeps() const { return config.sleeping && config.budget.method != Method::paper; }
  double timeStep() const { return config.frame / config.budget.substeps; }

  void takeGhosts(const Ghosts& ghosts);
  const std::vector<Solid>& withWalls(const std::vector<Solid>& solids, double farthest);
  void step(const Ghosts& ghosts, const std::vector<Solid>& solids, double from, float dt);
  void updateBonds();
  void publishAwake();
  Sculpture sculpture() const;
  void restore(const Sculpture& sculpture);
  void regroup();
  void endStep(float dt);
  void collectForces(int steps);

  ClayConfig config;
  std::vector<Material> materials;
  tbb::task_arena arena;
  Particles everyone;                // as the world sees them, also those that sleep
  std::vector<std::uint32_t> awake;  // which of them are awake, ascending
  Particles particles;               // those awake; everything below is of them
  VectorField free;                  // m, displacements of the step without internal and contact forces
  VectorField u;                     // m, displacements of the step
  RangeSums range_sums;
  Kernel kernel;
  Neighbourhood near;
  Minimiser minimiser;
  Projection projection;
  Bonds bond_constraint;
  Contacts contact_constraint;
  Sleep sleep;
  // Of those that sleep, with indices into `everyone`: bonds, from begin[i] to begin[i + 1], and contacts,
  // which press the solids with what they last did.
  std::vector<std::uint32_t> sleeping_bond_begin;
  std::vector<Bond> sleeping_bonds;
  std::vector<Contact> sleeping_contacts;
  bool bonded = false;
  VectorField window_start;        // m, positions when bonds were last decided on
  int window_steps = 0;            // steps since
  int iterations_done = 0;         // in this frame
  double time = 0.0, carry = 0.0;  // s
  Ghosts target;                   // ghosts at the end of the frame
  Ghosts moved;                    // and at the end of the current step
  std::vector<Solid> walls;        // of the world
  std::vector<Solid> walled;       // solids of the step and walls
  std::vector<Eigen::Isometry3d> start_poses, end_poses;
  std::vector<Eigen::Vector3d> ghost_sum;  // N
  std::vector<bool> ghost_touched;
  std::vector<GhostForce> ghost_forces;
  std::vector<Eigen::Vector3d> solid_forces;
  Statistics statistics;
};

Clay::State::State(const ClayConfig& config_in, std::vector<Material> materials_in,
                   const std::vector<InitialParticle>& initial)
    : config(config_in),
      materials(std::move(materials_in)),
      arena(config.threads > 0 ? config.threads : tbb::task_arena::automatic),
      kernel(static_cast<float>(2.0 * config.spacing)),
      near(kernel.h),
      minimiser(near, particles, kernel, config.spacing, materials),
      projection(kernel, static_cast<float>(config.spacing), materials),
      bond_constraint(static_cast<float>(config.spacing), materials),
      contact_constraint(static_cast<float>(config.spacing), materials),
      sleep(static_cast<float>(config.spacing)) {
  const std::size_t n = initial.size();
  everyone.position.resize(n), everyone.velocity.resize(n);
  everyone.density_ratio.assign(n, 1.0f);
  // What the clay starts with may be given back.
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
  for (const Material& m : materials) bonded = bonded || m.stiffness > 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Solid wall;
      wall.name = "world";
      wall.size.setConstant(2.0 * config.world);
      wall.pose.translation()[axis] = side * (3.0 * config.world + 0.5 * config.spacing);
      walls.push_back(wall);
    }
  }
  restore({0.0,
           0.0,
           0,
           config.spacing,
           everyone.position,
           everyone.velocity,
           everyone.compression,
           everyone.position,
           config.budget.substeps,
           everyone.material,
           everyone.body,
           std::vector<std::uint32_t>(n + 1, 0),
           {},
           {},
           {std::vector<std::uint32_t>(n, 0), everyone.position, 0.0}});
  statistics.stages = {{"neighbours"}, {"contact_search"}, {"bonds"}, {"setup"}, {"iterations"}, {"finish"}};
}

/// A ghost that is not finite, or has no unit normal, is put out of reach; one faster than any hand has
/// jumped, and has no velocity. Norms are compared because a NaN fails every comparison, while maxCoeff may
/// drop it.
void Clay::State::takeGhosts(const Ghosts& ghosts) {
  constexpr float fastest = 50.0f;  // m/s
  const float far = static_cast<float>(100.0 * config.world);
  target = ghosts;
  for (std::size_t g = 0; g < target.size(); ++g) {
    const bool unit = std::abs(target.normal[g].squaredNorm() - 1.0f) < 0.1f;
    if (!unit || !(target.position[g].norm() < far)) {
      target.position[g].setConstant(far);
      target.normal[g] = Eigen::Vector3f::UnitZ();
    }
    if (!(target.velocity[g].norm() < fastest)) target.velocity[g].setZero();
  }
  moved = target;
}

/// The walls of the world are solids like others, where any particle may come near.
/// \param farthest coordinate that a particle has or heads for, m
const std::vector<Solid>& Clay::State::withWalls(const std::vector<Solid>& solids, double farthest) {
  if (!(farthest > config.world - 2.0 * config.spacing)) return solids;
  walled = solids;
  walled.insert(walled.end(), walls.begin(), walls.end());
  return walled;
}

void Clay::State::step(const Ghosts& ghosts, const std::vector<Solid>& of_scene, double from, float dt) {
  const Eigen::Vector3f gravity = config.gravity.cast<float>();
  const Sums ways = range_sums.of(particles.size(), [&](std::size_t first, std::size_t last) {
    Sums sums;
    for (std::size_t i = first; i < last; ++i) {
      const Eigen::Vector3f x = particles.position.at(i),
                            way = dt * (particles.velocity.at(i) + dt * gravity);
      free.set(i, way);
      sums.largest = std::max({sums.largest, x.cwiseAbs().maxCoeff(), (x + way).cwiseAbs().maxCoeff()});
    }
    return sums;
  });
  const std::vector<Solid>& solids = withWalls(of_scene, ways.largest);
  {
    const Stopwatch watch(ms(neighbours));
    near.build(particles.position);
  }
  {
    const Stopwatch watch(ms(contact_search));
    start_poses.clear(), end_poses.clear();
    for (const Solid& s : solids) {
      start_poses.push_back(poseAfter(s, from));
      end_poses.push_back(poseAfter(s, from + dt));
    }
    contact_constraint.detect(near, particles, free, ghosts, solids, start_poses, end_poses, dt);
  }
  if (bonded) {
    const Stopwatch watch(ms(bonds));
    updateBonds();
  }
  const Bonds* const of_particles = bonded ? &bond_constraint : nullptr;
  if (config.budget.method == Method::paper) {
    const Stopwatch watch(ms(iterations));
    projection.solve(near, particles, of_particles, free, config.budget.iterations, dt, contact_constraint,
                     u);
  } else {
    {
      const Stopwatch watch(ms(setup));
      minimiser.begin(of_particles, free, contact_constraint, dt);
    }
    const Stopwatch watch(ms(iterations));
    iterations_done += minimiser.solve(gravity, ghosts, config.budget.iterations, config.tolerance, u);
  }
  endStep(dt);
}

/// Whether bonds form or break is decided by how far a pair has parted in a frame, not by the velocities of a
/// step: these carry the noise of the solver, and a threshold that is looked at more often is crossed more
/// often. A bond breaks as soon as its frame is sure to be too fast; what forms does so at the end of one.
void Clay::State::updateBonds() {
  const float per_frame = static_cast<float>(1.0 / config.frame);
  const bool ends = window_steps >= config.budget.substeps;
  VectorField& mean_velocity = u;  // which is free until the step is solved
  parallelRanges(particles.size(), range_size, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      mean_velocity[i] = per_frame * (particles.position[i] - window_start[i]);
      if (ends) window_start[i] = particles.position[i];
    }
  });
  bond_constraint.update(near, particles, mean_velocity, ends);
  window_steps = ends ? 1 : window_steps + 1;
}

void Clay::State::endStep(float dt) {
  const Stopwatch watch(ms(finish));
  const float world = static_cast<float>(config.world);
  const bool minimised = config.budget.method != Method::paper;
  parallelRanges(particles.size(), range_size, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      // A displacement that is not finite, or larger than the world, is a lost particle: it stops where it
      // is.
      Eigen::Vector3f step = u.at(i);
      if (!(step.norm() < 2.0f * world)) step.setZero();
      const Eigen::Vector3f next = particles.position.at(i) + step;
      const Eigen::Vector3f inside = next.cwiseMax(-world).cwiseMin(world);
      particles.position.set(i, inside);
      particles.velocity.set(i, (inside.array() == next.array()).select(step / dt, 0.0f));
      if (minimised) particles.compression[i] = minimiser.compression(i);
    }
  });
}

void Clay::State::publishAwake() {
  for (std::size_t k = 0; k < awake.size(); ++k) {
    everyone.position[awake[k]] = particles.position[k];
    everyone.velocity[awake[k]] = particles.velocity[k];
    everyone.density_ratio[awake[k]] = particles.density_ratio[k];
    everyone.compression[awake[k]] = particles.compression[k];
  }
}

Sculpture Clay::State::sculpture() const {
  Sculpture s{time,
              carry,
              statistics.step,
              config.spacing,
              everyone.position,
              everyone.velocity,
              everyone.compression,
              everyone.position,
              window_steps,
              everyone.material,
              everyone.body,
              {0},
              {},
              sleeping_contacts,
              sleep.state()};
  for (std::size_t k = 0; k < awake.size(); ++k) s.window_start[awake[k]] = window_start[k];
  std::size_t k = 0;
  for (std::size_t i = 0; i < everyone.size(); ++i) {
    if (k < awake.size() && awake[k] == i) {
      for (const Bond* b = bond_constraint.begin(k); b != bond_constraint.end(k); ++b)
        s.bonds.push_back({awake[b->other], b->rest_length});
      ++k;
    } else {
      s.bonds.insert(s.bonds.end(), sleeping_bonds.begin() + sleeping_bond_begin[i],
                     sleeping_bonds.begin() + sleeping_bond_begin[i + 1]);
    }
    s.bond_begin.push_back(static_cast<std::uint32_t>(s.bonds.size()));
  }
  for (Contact c : contact_constraint.contacts()) {
    c.particle = awake[c.particle];
    s.contacts.push_back(c);
  }
  std::stable_sort(s.contacts.begin(), s.contacts.end(),
                   [](const Contact& a, const Contact& b) { return a.particle < b.particle; });
  return s;
}

/// Takes over a sculpture, and parts what is awake from what sleeps.
void Clay::State::restore(const Sculpture& s) {
  constexpr std::uint32_t nobody = 0xffffffffu;
  time = s.time, carry = s.carry;
  statistics.step = s.step;
  window_steps = s.window_steps;
  everyone.position = s.position, everyone.velocity = s.velocity;
  everyone.compression = s.compression;
  sleep.restore(s.sleep, everyone);
  awake = sleep.awake();

  const std::size_t n = everyone.size();
  std::vector<std::uint32_t> index(n, nobody);  // in `awake`
  particles = {};
  for (VectorField* field : {&particles.position, &particles.velocity, &window_start, &free, &u})
    field->resize(awake.size());
  for (std::uint32_t k = 0; k < awake.size(); ++k) {
    const std::uint32_t i = awake[k];
    index[i] = k;
    particles.position[k] = everyone.position[i];
    particles.velocity[k] = everyone.velocity[i];
    window_start[k] = s.window_start[i];
    particles.inverse_mass.push_back(everyone.inverse_mass[i]);
    particles.density_ratio.push_back(everyone.density_ratio[i]);
    particles.compression.push_back(everyone.compression[i]);
    particles.material.push_back(everyone.material[i]);
    particles.body.push_back(everyone.body[i]);
  }
  std::vector<std::uint32_t> begins{0};
  std::vector<Bond> awake_bonds;
  sleeping_bond_begin.assign(1, 0), sleeping_bonds.clear();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::uint32_t b = s.bond_begin[i]; b < s.bond_begin[i + 1]; ++b) {
      const Bond& bond = s.bonds[b];
      if (index[i] == nobody)
        sleeping_bonds.push_back(bond);
      else if (index[bond.other] != nobody)
        awake_bonds.push_back({index[bond.other], bond.rest_length});
    }
    if (index[i] != nobody) begins.push_back(static_cast<std::uint32_t>(awake_bonds.size()));
    sleeping_bond_begin.push_back(static_cast<std::uint32_t>(sleeping_bonds.size()));
  }
  bond_constraint.restore(begins, std::move(awake_bonds));
  sleeping_contacts.clear();
  std::vector<Contact>& contacts = contact_constraint.contacts();
  contacts.clear();
  for (Contact c : s.contacts) {
    if (index[c.particle] == nobody) {
      sleeping_contacts.push_back(c);
      continue;
    }
    c.particle = index[c.particle];
    contacts.push_back(c);
  }
}

/// After clay woke or fell asleep.
void Clay::State::regroup() {
  publishAwake();
  for (std::size_t i = 0; i < everyone.size(); ++i)
    if (sleep.state().lump[i] != 0) everyone.velocity[i].setZero();
  restore(sculpture());
}

void Clay::State::collectForces(int steps) {
  for (const Contact& c : sleeping_contacts)
    if (c.solid < solid_forces.size()) solid_forces[c.solid] -= c.force.cast<double>() / steps;
  for (const Contact& c : contact_constraint.contacts()) {
    const Eigen::Vector3d force = -c.force.cast<double>() / steps;
    if (c.solid != Contact::skin) {
      if (c.solid < solid_forces.size()) solid_forces[c.solid] += force;
      continue;
    }
    if (c.force.isZero(0.0f)) continue;
    for (std::uint32_t s = c.first_ghost; s < c.first_ghost + c.ghost_count; ++s) {
      const GhostShare& share = contact_constraint.shares()[s];
      ghost_sum[share.ghost] += share.share * force;
      ghost_touched[share.ghost] = true;
    }
  }
}

Clay::Clay(const ClayConfig& config, std::vector<Material> materials,
           std::vector<InitialParticle> particles) {
  validate(config);
  if (materials.empty()) throw std::invalid_argument("clay: no material given, expected at least one");
  for (const Material& m : materials) validate(m);
  state_ = std::make_unique<State>(config, std::move(materials), particles);
}

Clay::~Clay() = default;

void Clay::advance(const Ghosts& ghosts, const std::vector<Solid>& solids, double duration) {
  State& s = *state_;
  for (Stage& stage : s.statistics.stages) stage.ms = 0.0;
  s.iterations_done = 0;
  const double dt = s.timeStep();
  s.carry += duration;
  const int steps = std::max(static_cast<int>(std::lround(s.carry / dt)), 0);
  s.carry -= steps * dt;
  ++s.statistics.step;
  if (steps == 0) {
    auto& forces = s.ghost_forces;
    forces.erase(std::remove_if(forces.begin(), forces.end(),
                                [&](const GhostForce& f) { return f.ghost >= ghosts.size(); }),
                 forces.end());
    return;
  }

  s.ghost_sum.assign(ghosts.size(), Eigen::Vector3d::Zero());
  s.ghost_touched.assign(ghosts.size(), false);
  s.solid_forces.assign(solids.size(), Eigen::Vector3d::Zero());
  s.takeGhosts(ghosts);
  s.arena.execute([&] {
    for (int k = 0; k < steps; ++k) {
      const float remaining = static_cast<float>((steps - 1 - k) * dt);
      for (std::size_t g = 0; g < ghosts.size(); ++g) {
        s.moved.position[g] = s.target.position[g] - remaining * s.target.velocity[g];
      }
      const Surroundings around{s.moved, solids, k * dt, static_cast<float>(dt)};
      if (s.sleeps() && s.sleep.wake(s.everyone, s.particles, around)) s.regroup();
      s.step(s.moved, solids, k * dt, static_cast<float>(dt));
      s.collectForces(steps);
    }
    s.particles.density_ratio =
        s.config.budget.method == Method::paper ? s.projection.densityRatio() : s.minimiser.densityRatio();
    s.publishAwake();
  });
  s.time += steps * dt;
  double error = 0.0, largest = 0.0;
  for (const float ratio : s.everyone.density_ratio) {
    const double excess = std::max(ratio - 1.0, 0.0);
    error += excess;
    largest = std::max(largest, excess);
  }
  s.statistics.density_error_mean = s.everyone.size() ? error / s.everyone.size() : 0.0;
  s.statistics.density_error_max = largest;
  s.statistics.awake = s.particles.size();
  s.statistics.iterations = static_cast<double>(s.iterations_done) / steps;
  s.statistics.bonds = s.bond_constraint.size() + s.sleeping_bonds.size() / 2;
  s.statistics.contacts = s.contact_constraint.contacts().size() + s.sleeping_contacts.size();
  s.ghost_forces.clear();
  for (std::size_t g = 0; g < ghosts.size(); ++g) {
    if (s.ghost_touched[g]) {
      s.ghost_forces.push_back({static_cast<std::uint32_t>(g), s.ghost_sum[g].cast<float>()});
    }
  }
  const Surroundings around{s.moved, solids, (steps - 1) * dt, static_cast<float>(dt)};
  if (s.sleeps() && s.sleep.settle(s.particles, s.near, around, steps * dt)) s.regroup();
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
  s.restore(sculpture);
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
const std::vector<GhostForce>& Clay::ghostForces() const {
  return state_->ghost_forces;
}
const std::vector<Eigen::Vector3d>& Clay::solidForces() const {
  return state_->solid_forces;
}
const Statistics& Clay::statistics() const {
  return state_->statistics;
}

}  // namespace tactile_clay::clay
