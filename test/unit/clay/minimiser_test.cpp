#include "clay/solver/minimiser.h"

#include <gtest/gtest.h>

#include "clouds.h"
#include "support/setups.h"

namespace tactile_clay::clay::minimiser_test {
namespace {

constexpr float spacing = 0.005f, dt = 1.0f / 240.0f, particle_mass = 2e-4f;
constexpr int edge = 5;
const Eigen::Vector3f gravity(0.0f, 0.0f, -9.81f), weightless = Eigen::Vector3f::Zero();
constexpr double exact = 0.0;  // tolerance, m/s^2: all iterations are done

/// One step of a cube of clay.
struct Step {
  /// @param apart spacings, between the particles
  explicit Step(const Eigen::Vector3f& centre = {0.0f, 0.0f, 0.5f}, float apart = 1.0f) {
    std::vector<Eigen::Vector3f> points;
    for (const Eigen::Vector3f& p : lattice(edge, apart * spacing, 0.05f)) points.push_back(p + centre);
    particles = particlesAt(points, particle_mass);
    near.build(particles.position);
    bonds.update(near, particles, particles.velocity, true);
  }
  int solve(int iterations, const Eigen::Vector3f& g, const std::vector<Solid>& solids = {}) {
    free = zeros(particles.size());
    for (std::size_t i = 0; i < particles.size(); ++i) free.set(i, dt * (particles.velocity.at(i) + dt * g));
    std::vector<Eigen::Isometry3d> poses;
    for (const Solid& s : solids) poses.push_back(s.pose);
    near.build(particles.position);
    contacts.detect(near, particles, free, {samples, solids, poses, poses, dt});
    bonds.update(near, particles, particles.velocity, true);
    u = zeros(particles.size());
    return minimiser.solve({near, particles, &bonds, free, dt}, contacts, {g, iterations, exact}, u)
        .iterations;
  }
  void shake(float speed, unsigned seed) {
    std::mt19937 random(seed);
    particles.velocity = randomField(particles.size(), random, speed);
  }
  /// The particles before the step, with the velocities with which they would make these displacements in it.
  Particles moving(const VectorField& displacements) const {
    Particles p = particles;
    for (std::size_t i = 0; i < p.size(); ++i) p.velocity.set(i, displacements.at(i) / dt);
    return p;
  }
  double distance(const VectorField& other) const {  // m, root mean square, of u
    double square = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) square += (u.at(i) - other.at(i)).squaredNorm();
    return std::sqrt(square / static_cast<double>(u.size()));
  }

  const std::vector<Material> materials{Material{}};
  const Kernel kernel{2.0f * spacing};
  Particles particles;
  Neighbourhood near{2.0f * spacing};
  Bonds bonds{spacing, materials};
  Skin samples;
  Contacts contacts{spacing, materials};
  Minimiser minimiser{kernel, spacing, materials};
  VectorField free, u;
};

TEST(Minimiser, ARigidFlightIsItsOwnSolution) {
  Step step({0.0f, 0.0f, 0.5f}, 1.06f);  // no particle is compressed, for all that they are displaced
  for (std::size_t i = 0; i < step.particles.size(); ++i) step.particles.velocity.set(i, {0.3f, -0.2f, 1.0f});
  step.solve(8, gravity);
  // Bonds are at rest: no force but gravity.
  EXPECT_LT(step.distance(step.free), 1e-4 * dt);
}

/// Internal forces cancel, in the few iterations of `fast` as well as solved to the end.
TEST(Minimiser, KeepsMomentaForAnyBudget) {
  for (const int iterations : {1, 2, 4, 8, 32}) {
    Step step;
    step.shake(0.5f, 3);
    step.solve(iterations, weightless);
    const Particles before = step.moving(step.free), after = step.moving(step.u);
    const double scale = 0.5 * totalMass(before);  // kg m/s, were all in one direction
    EXPECT_LT((momentum(after) - momentum(before)).norm(), 1e-6 * scale) << iterations;
    EXPECT_LT((angularMomentum(after) - angularMomentum(before)).norm(), 1e-4 * edge * spacing * scale)
        << iterations;
    EXPECT_GT(step.distance(step.free), 0.1f * 0.5f * dt) << iterations;  // it has done something
  }
}

/// Implicit Euler takes energy, never gives any, however few directions are tried.
TEST(Minimiser, TakesEnergyForAnyBudget) {
  for (const int iterations : {1, 2, 4, 8, 32}) {
    Step step;
    step.shake(0.5f, 5);
    step.solve(iterations, weightless);
    EXPECT_LT(kineticEnergy(step.moving(step.u)), kineticEnergy(step.moving(step.free))) << iterations;
  }
}

/// Conjugate gradients: the more directions, the nearer to the solution, and near it in a tenth of the
/// unknowns.
TEST(Minimiser, MoreIterationsComeNearerToTheSolution) {
  Step step;
  step.shake(0.2f, 7);
  step.solve(400, weightless);
  const VectorField solution = step.u;
  const double start = step.distance(step.free);
  double last = start;
  for (const int iterations : {1, 4, 16, 64}) {
    step.solve(iterations, weightless);
    EXPECT_LT(step.distance(solution), last) << iterations;
    last = step.distance(solution);
  }
  EXPECT_LT(last, 0.01 * start);
}

TEST(Minimiser, ContactsCarryTheWeightWithOneIterationToo) {
  for (const int iterations : {1, 8}) {
    Step step({0.0f, 0.0f, 0.5f * (edge - 1) * spacing + 0.5f * spacing});
    Eigen::Vector3d force;
    for (int k = 0; k < 60; ++k) {  // until it rests
      step.solve(iterations, gravity, {ground()});
      force.setZero();
      for (const Contact& c : step.contacts.contacts()) force += c.force.cast<double>();
      Eigen::Vector3d inertial = Eigen::Vector3d::Zero();
      for (std::size_t i = 0; i < step.u.size(); ++i)
        inertial += particle_mass / (dt * dt) * (step.u.at(i) - step.free.at(i)).cast<double>();
      // Eq. 6: the sum of the forces is the rate of momentum.
      EXPECT_LT((force - inertial).norm(), 1e-3 * (inertial.norm() + 1e-2)) << k;
      for (std::size_t i = 0; i < step.u.size(); ++i) {
        step.particles.position.add(i, step.u.at(i));
        step.particles.velocity.set(i, step.u.at(i) / dt);
      }
    }
    const double weight = particle_mass * 9.81 * static_cast<double>(step.particles.size());
    EXPECT_NEAR(force.z(), weight, 0.01 * weight) << iterations;
  }
}

/// Lumps do not interact: a crumb that is thrown beside a block at rest changes nothing of the block's step.
TEST(Minimiser, ALumpIsSolvedAsIfItWereAlone) {
  Step alone;
  alone.shake(0.3f, 9);
  Step beside;
  std::vector<Eigen::Vector3f> points;
  for (std::size_t i = 0; i < alone.particles.size(); ++i) points.push_back(alone.particles.position.at(i));
  for (int k = 0; k < 3; ++k) points.emplace_back(0.3f + static_cast<float>(k) * spacing, 0.0f, 0.5f);
  beside.particles = particlesAt(points, particle_mass);
  beside.near.build(beside.particles.position);
  beside.bonds.update(beside.near, beside.particles, beside.particles.velocity, true);
  std::mt19937 random(21);
  for (std::size_t i = 0; i < points.size(); ++i) {
    beside.particles.velocity.set(
        i, i < alone.particles.size() ? alone.particles.velocity.at(i) : randomVector(random, 5.0f));
  }
  alone.solve(8, weightless);
  beside.solve(8, weightless);
  for (std::size_t i = 0; i < alone.u.size(); ++i)
    EXPECT_LT((alone.u.at(i) - beside.u.at(i)).norm(), 1e-3f * 0.3f * dt) << i;
}

}  // namespace
}  // namespace tactile_clay::clay::minimiser_test
