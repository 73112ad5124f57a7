#include "clay/paper/projection.h"

#include <gtest/gtest.h>

#include <cstring>

#include "clay/clay.h"
#include "clay/lattice.h"
#include "clouds.h"
#include "support/setups.h"

/// The paper's scheme (`solver: paper`): each constraint alone reduces its own error, corrections are equal
/// and opposite, and the iteration count is the material.
namespace tactile_clay::clay::projection_test {
namespace {

constexpr float spacing = 0.005f, dt = 1.0f / 60.0f;

Material nothing() {
  Material m;
  m.bulk_modulus = 0.0;
  m.viscosity = 0.0;
  m.stiffness = 0.0;
  m.friction = m.skin_friction = 0.0;
  return m;
}

/// One step of particles without gravity.
struct Bench {
  Bench(const std::vector<Eigen::Vector3f>& points, const Material& material)
      : materials{material},
        particles(particlesAt(points, 1600.0f * spacing * spacing * spacing)),
        near(kernel.h),
        bonds(spacing, materials),
        projection(kernel, spacing, materials) {
    near.build(particles.position);
    bonds.update(near, particles, particles.velocity, true);
  }

  VectorField solve(const VectorField& free, int iterations) {
    VectorField u;
    const Bonds* const held = materials[0].stiffness > 0.0 ? &bonds : nullptr;
    projection.solve({near, particles, held, free, dt}, iterations, {}, u);
    return u;
  }

  /// Largest rho / rho_0 after the displacements u.
  double densest(const VectorField& u) const {
    VectorField moved = particles.position;
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += u[i];
    Neighbourhood after(kernel.h);
    after.build(moved);
    double largest = 0.0;
    for (std::size_t i = 0; i < moved.size(); ++i) {
      double total = kernel.sigma;
      for (std::uint32_t p = after.begin(i); p < after.end(i); ++p)
        total += kernel.value(after.offset(p).norm());
      largest = std::max(largest, total / latticeSum(kernel, spacing));
    }
    return largest;
  }

  Kernel kernel{2.0f * spacing};
  std::vector<Material> materials;
  Particles particles;
  Neighbourhood near;
  Bonds bonds;
  Projection projection;
};

Material all() {
  Material m;
  m.bond_rate = 1e3;
  m.unbond_rate = 1e4;
  return m;
}

TEST(Projection, DensityExpandsWhatIsCompressed) {
  Material m = nothing();
  m.bulk_modulus = 1e6;
  const auto points = lattice(6, 0.95f * spacing, 0.0f);
  Bench bench(points, m);
  const double before = bench.densest(zeros(points.size())) - 1.0;
  ASSERT_GT(before, 0.1);
  const double few = bench.densest(bench.solve(zeros(points.size()), 5)) - 1.0,
               many = bench.densest(bench.solve(zeros(points.size()), 50)) - 1.0;
  EXPECT_LT(few, 0.8 * before);
  EXPECT_LT(many, 0.25 * before);
}

TEST(Projection, DensityLeavesAStretchedLatticeAlone) {
  Material m = nothing();
  m.bulk_modulus = 1e6;
  const auto points = lattice(5, 1.1f * spacing, 0.0f);
  Bench bench(points, m);
  const VectorField u = bench.solve(zeros(points.size()), 5);
  for (std::size_t i = 0; i < u.size(); ++i) EXPECT_EQ(u.at(i).norm(), 0.0f);
}

/// Strain rate dv_x/dz + dv_z/dx left of a uniform shear, by least squares.
double shearLeft(double viscosity, int iterations) {
  Material m = nothing();
  m.viscosity = viscosity;
  const auto points = lattice(6, spacing, 0.0f);
  Bench bench(points, m);
  VectorField free = zeros(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) free.set(i, {0.05f * points[i].z(), 0.0f, 0.0f});
  const VectorField u = bench.solve(free, iterations);
  double zz = 0.0, shear = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    zz += points[i].z() * points[i].z();
    shear += u.at(i).x() * points[i].z() + u.at(i).z() * points[i].x();
  }
  return shear / zz / 0.05;
}

TEST(Projection, ViscosityBrakesAShearFlow) {
  EXPECT_NEAR(shearLeft(0.0, 10), 1.0, 1e-6);
  const double few = shearLeft(1e6, 5), many = shearLeft(1e6, 100);
  EXPECT_LT(few, 0.9);
  EXPECT_LT(many, 0.1);
  EXPECT_GT(many, -0.1);
  // a converged step of implicit Euler: the compliance gives the coefficient its meaning
  EXPECT_GT(shearLeft(0.1, 200), 5.0 * std::abs(many));
}

TEST(Projection, ViscosityDoesNotBrakeARotation) {
  Material m = nothing();
  m.viscosity = 1e6;
  const auto points = lattice(6, spacing, 0.1f);
  Bench bench(points, m);
  const Eigen::Matrix3f turn =
      Eigen::AngleAxisf(0.3f, Eigen::Vector3f(1.0f, 2.0f, 2.0f) / 3.0f).toRotationMatrix();
  VectorField free = zeros(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) free.set(i, turn * points[i] - points[i]);
  const VectorField u = bench.solve(free, 20);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT((u.at(i) - free.at(i)).norm(), 1e-4f * points[i].norm());
}

TEST(Projection, BondsRestoreTheirLength) {
  Material m = nothing();
  m.stiffness = 1e5;
  const auto points = lattice(4, spacing, 0.0f);
  Bench bench(points, m);
  VectorField free = zeros(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) free.set(i, {0.2f * points[i].x(), 0.0f, 0.0f});
  const auto error = [&](const VectorField& u) {
    double sum = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (const Bond* bond = bench.bonds.begin(i); bond != bench.bonds.end(i); ++bond) {
        const Eigen::Vector3f offset = points[i] + u.at(i) - points[bond->other] - u.at(bond->other);
        sum += std::pow(offset.norm() - bond->rest_length, 2.0);
      }
    }
    return std::sqrt(sum);
  };
  ASSERT_GT(bench.bonds.size(), 100u);
  const double before = error(free);
  EXPECT_LT(error(bench.solve(free, 5)), 0.8 * before);
  EXPECT_LT(error(bench.solve(free, 50)), 0.1 * before);
}

/// Momentum of free clay is kept to rounding, whatever is projected; two masses, all constraints.
TEST(Projection, KeepsMomentum) {
  auto points = lattice(6, 0.9f * spacing, 0.2f);
  Bench bench(points, all());
  for (std::size_t i = 0; i < points.size(); i += 2) bench.particles.inverse_mass[i] *= 0.2f;
  std::mt19937 random(5);
  const VectorField free = randomField(points.size(), random, 0.2f * spacing);
  const VectorField u = bench.solve(free, 5);
  Eigen::Vector3d change = Eigen::Vector3d::Zero();
  double size = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d moved = (u.at(i) - free.at(i)).cast<double>() / bench.particles.inverse_mass[i];
    change += moved;
    size += moved.norm();
  }
  ASSERT_GT(size, 0.0);
  EXPECT_LT(change.norm(), 1e-6 * size);
}

ClayConfig paper(int substeps, int iterations, int threads = 2) {
  ClayConfig config;
  config.budget = {substeps, iterations, Method::paper};
  config.threads = threads;
  return config;
}

/// Height, m, of a cube of 40 mm above an incline of 20 degrees, 1.2 s after it was set down from 5 mm.
double heightOnIncline(int substeps, int iterations) {
  const double slope = 20.0 * M_PI / 180.0;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(slope, Eigen::Vector3d::UnitY()).toRotationMatrix();
  Clay clay(paper(substeps, iterations), {Material()}, block(8, 8, 8, spacing, 0.005 * turn.col(2), turn));
  for (int k = 0; k < 72; ++k) clay.advance({}, {ground(slope)}, clay.config().frame);
  EXPECT_TRUE(allFinite(clay.particles()));
  return extent(clay.particles(), turn.col(2)).second + 0.5 * spacing;
}

/// The same clay ends as a puddle or as a block.
TEST(Projection, TheIterationCountIsTheMaterial) {
  const double two = heightOnIncline(4, 2), four = heightOnIncline(4, 4), converged = heightOnIncline(4, 64),
               operating_point = heightOnIncline(1, 5);
  EXPECT_LT(operating_point, 0.5 * converged);
  EXPECT_LT(two, 0.7 * converged);
  EXPECT_LT(two, four);
  EXPECT_LT(four, 0.9 * converged);
  EXPECT_NEAR(converged, 0.0405, 0.001);
}

/// Eq. 6 summed over the iterations is the true force, however few they are.
TEST(Projection, ARestingBlockPressesWithItsWeight) {
  for (const bool skin : {false, true}) {
    Clay clay(paper(4, 5), {Material()}, block(5, 5, 5, spacing));
    const Skin palm =
        skin ? samplePlane(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 0.03, 0.004) : Skin();
    const std::vector<Solid> table = skin ? std::vector<Solid>() : std::vector<Solid>{ground()};
    for (int k = 0; k < 90; ++k) clay.advance(palm, table, clay.config().frame);
    Eigen::Vector3d force = skin ? Eigen::Vector3d::Zero() : clay.solidForces()[0];
    for (const SkinForce& f : clay.skinForces()) force += f.force.cast<double>();
    const double weight = 9.81 * totalMass(clay.particles());
    EXPECT_NEAR(-force.z(), weight, 1e-3 * weight) << (skin ? "skin" : "table");
  }
}

TEST(Projection, FrictionHoldsAndSlidesByCoulomb) {
  struct Measured {
    double acceleration, friction;  // m/s^2, down the slope; of the block's weight, on the ground
  };
  const auto onSlope = [](double slope) -> Measured {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(slope, Eigen::Vector3d::UnitY()).toRotationMatrix();
    Clay clay(paper(4, 64), {Material()}, block(5, 5, 4, spacing, 1e-5 * turn.col(2), turn));
    const double mass = totalMass(clay.particles());
    const auto speed = [&] { return turn.col(0).dot(momentum(clay.particles())) / mass; };
    for (int k = 0; k < 30; ++k) clay.advance({}, {ground(slope)}, clay.config().frame);
    const double before = speed();
    double friction = 0.0;
    for (int k = 0; k < 30; ++k) {
      clay.advance({}, {ground(slope)}, clay.config().frame);
      friction += turn.col(0).dot(clay.solidForces()[0]) / 30.0;
    }
    return {(speed() - before) / 0.5, friction / (9.81 * mass)};
  };
  const double gentle = 29.0 * M_PI / 180.0, steep = 36.0 * M_PI / 180.0;  // atan 0.6 = 31 degrees
  const Measured holds = onSlope(gentle), slides = onSlope(steep);
  EXPECT_NEAR(holds.acceleration, 0.0, 0.01);
  EXPECT_NEAR(holds.friction, std::sin(gentle), 0.002);
  EXPECT_NEAR(slides.acceleration, 9.81 * (std::sin(steep) - 0.6 * std::cos(steep)), 0.05);
  EXPECT_NEAR(slides.friction, 0.6 * std::cos(steep), 0.005);
}

/// An anchor that stayed where the slide began would draw the block back.
TEST(Projection, WhatSlidesComesToRestWhereCoulombSaysAndStays) {
  std::vector<InitialParticle> particles = block(5, 5, 4, spacing);
  for (InitialParticle& p : particles) p.velocity = {0.5f, 0.0f, 0.0f};
  Clay clay(paper(4, 64), {Material()}, particles);
  const auto x = [&] { return centreOfMass(clay.particles()).x(); };
  const double start = x();
  for (int k = 0; k < 30; ++k) clay.advance({}, {ground()}, clay.config().frame);
  const double rest = x();
  EXPECT_NEAR(rest - start, 0.5 * 0.5 / (2.0 * 0.6 * 9.81), 0.0015);
  for (int k = 0; k < 30; ++k) clay.advance({}, {ground()}, clay.config().frame);
  EXPECT_NEAR(x(), rest, 1e-4);
}

TEST(Projection, GivesTheSameBitsForAnyNumberOfThreads) {
  std::vector<VectorField> positions;
  for (const int threads : {1, 2, 3}) {
    Clay clay(paper(1, 5, threads), {Material()}, block(8, 8, 6, spacing));
    for (int k = 0; k < 30; ++k) {
      const Eigen::Vector3d velocity(0.0, 0.0, -0.1);
      clay.advance(sampleBall({0.0, 0.0, 0.05 - 0.1 * dt * k}, 0.015, 0.005, velocity), {ground()},
                   clay.config().frame);
    }
    positions.push_back(clay.particles().position);
  }
  for (const VectorField& x : positions)
    EXPECT_EQ(std::memcmp(&x[0], &positions[0][0], x.size() * sizeof(x[0])), 0);
}

TEST(Projection, IsChosenByName) {
  EXPECT_EQ(methodNamed("paper"), Method::paper);
  EXPECT_EQ(methodNamed("minimise"), Method::minimise);
  try {
    methodNamed("magic");
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_STREQ(e.what(), "solver 'magic', expected minimise or paper");
  }
}

}  // namespace
}  // namespace tactile_clay::clay::projection_test
