#include "clay/clay_state.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "clay/threads.h"

namespace tactile_clay::clay {
namespace {

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

Clay::State::State(const ClayConfig& config_in, std::vector<Material> materials_in,
                   const std::vector<InitialParticle>& initial)
    : config(config_in),
      materials(std::move(materials_in)),
      team(config.threads),
      kernel(static_cast<float>(2.0 * config.spacing)),
      near(kernel.h),
      minimiser(near, particles, kernel, config.spacing, materials),
      projection(kernel, static_cast<float>(config.spacing), materials),
      bond_constraint(static_cast<float>(config.spacing), materials),
      contact_constraint(static_cast<float>(config.spacing), materials),
      sleep(static_cast<float>(config.spacing), crumb_size) {
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

/// A ghost that is not finite, is far out of the world or has no unit normal does not exist; one faster than
/// any hand has jumped, and has no velocity. Norms are compared because a NaN fails every comparison, while
/// maxCoeff may drop it.
void Clay::State::takeGhosts(const Ghosts& ghosts) {
  constexpr float fastest = 50.0f;  // m/s
  const float far = static_cast<float>(100.0 * config.world);
  target = ghosts;
  for (std::size_t g = 0; g < target.size(); ++g) {
    const bool unit = std::abs(target.normal[g].squaredNorm() - 1.0f) < 0.1f;
    const bool exists = unit && target.position[g].norm() < std::min(far, Ghosts::nowhere);
    if (!exists) {
      target.position[g].setConstant(Ghosts::nowhere);
      target.normal[g] = Eigen::Vector3f::UnitZ();
    }
    if (!exists || !(target.velocity[g].norm() < fastest)) target.velocity[g].setZero();
  }
  moved = target;
}

/// The walls of the world are solids like others, where any particle may come near.
/// \param farthest coordinate that a particle has or heads for, m
Surroundings Clay::State::withWalls(const Surroundings& around, double farthest) {
  if (!(farthest > config.world - 2.0 * config.spacing)) return around;
  walled = around.solids, walled_start = around.start, walled_end = around.end;
  for (const Solid& wall : walls) {
    walled.push_back(wall);
    walled_start.push_back(wall.pose), walled_end.push_back(wall.pose);
  }
  return {around.ghosts, walled, walled_start, walled_end, around.dt};
}

/// Sets `end_poses`. \param solids how many there are
void Clay::State::posesAt(const SolidMotion& motion, double t, std::size_t solids) {
  motion(t, end_poses);
  if (end_poses.size() != solids)
    throw std::invalid_argument("clay: " + std::to_string(end_poses.size()) + " poses of " +
                                std::to_string(solids) + " solids, expected one each");
}

Surroundings Clay::State::surroundings(const std::vector<Solid>& solids) const {
  return {moved, solids, start_poses, end_poses, static_cast<float>(config.timeStep())};
}

void Clay::State::step(const Surroundings& around) {
  const float dt = around.dt;
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
  const Surroundings walled_in = withWalls(around, ways.largest);
  {
    const Stopwatch watch(ms(neighbours));
    near.build(particles.position);
  }
  {
    const Stopwatch watch(ms(contact_search));
    contact_constraint.detect(near, particles, free, walled_in.ghosts, walled_in.solids, walled_in.start,
                              walled_in.end, dt);
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
    iterations_done += minimiser.solve(gravity, config.budget.iterations, config.tolerance, u);
    rounds_done += minimiser.rounds();
    statistics.ghosts_looked_at += contact_constraint.looks();
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
  bond_constraint.update(near, particles, mean_velocity, ends, static_cast<float>(config.timeStep()),
                         contact_constraint.contacts());
  window_steps = ends ? 1 : window_steps + 1;
}

void Clay::State::endStep(float dt) {
  const Stopwatch watch(ms(finish));
  const float world = static_cast<float>(config.world);
  const bool minimised = config.budget.method != Method::paper;
  const VectorField* const recovery = minimised ? minimiser.recovery() : nullptr;
  parallelRanges(particles.size(), range_size, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      // A displacement that is not finite, or larger than the world, is a lost particle: it stops where it
      // is.
      Eigen::Vector3f step = u.at(i);
      if (!(step.norm() < 2.0f * world)) step.setZero(), ++rejected;
      Eigen::Vector3f next = particles.position.at(i) + step;
      if (recovery != nullptr && recovery->at(i).norm() < world) next += recovery->at(i);
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
              sleep.state(),
              everyone.density_ratio};
  for (std::size_t k = 0; k < awake.size(); ++k) s.window_start[awake[k]] = window_start[k];
  // Sculptures are kept for undo, a hundred and more: none takes more memory than it needs.
  s.bond_begin.reserve(everyone.size() + 1);
  s.bonds.reserve(2 * bond_constraint.size() + sleeping_bonds.size());
  s.contacts.reserve(s.contacts.size() + contact_constraint.contacts().size());
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
  if (!s.density_ratio.empty()) everyone.density_ratio = s.density_ratio;
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

/// Of the last step.
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

/// Of the last step: an anchor that holds does not slide, one that is dragged along moves with its particle.
void Clay::State::collectForces(int steps, float dt) {
  for (const Contact& c : sleeping_contacts)
    if (c.solid < solid_forces.size()) solid_forces[c.solid] -= c.force.cast<double>() / steps;
  for (const Contact& c : contact_constraint.contacts()) {
    const Eigen::Vector3d force = -c.force.cast<double>() / steps;
    if (c.solid != Contact::skin) {
      if (c.solid < solid_forces.size()) solid_forces[c.solid] += force;
      continue;
    }
    if (c.force.isZero(0.0f)) continue;
    const Eigen::Vector3f way = u.at(c.particle) - c.drift;
    const double size = force.norm();
    const bool slides = c.state == Contact::State::slide || !(c.stiffness > 0.0f);  // or nothing holds it
    double slip = slides ? (way - way.dot(c.normal) * c.normal).norm() / dt : 0.0;
    if (!std::isfinite(slip)) slip = 0.0;  // of a particle that is lost in this step
    for (std::uint32_t s = c.first_ghost; s < c.first_ghost + c.ghost_count; ++s) {
      const GhostShare& share = contact_constraint.shares()[s];
      ghost_sum[share.ghost] += share.share * force;
      ghost_pressed[share.ghost] += share.share * size;
      ghost_slip[share.ghost] += share.share * size * slip;
      ghost_touched[share.ghost] = true;
    }
  }
}

}  // namespace tactile_clay::clay
