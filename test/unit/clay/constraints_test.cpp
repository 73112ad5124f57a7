#include <gtest/gtest.h>

#include "clay/kernel.h"
#include "clay/lattice.h"
#include "clouds.h"
#include "support/setups.h"

/// Each constraint family alone reduces its own error in one frame.
namespace tactile_clay::clay::constraints_test {
namespace {

constexpr double spacing = 0.005;

Material nothing() {
  Material m;
  m.bulk_modulus = 0.0;
  m.viscosity = 0.0;
  m.stiffness = 0.0;
  m.friction = m.skin_friction = 0.0;
  return m;
}

ClayConfig weightless(int substeps = 4, int iterations = 8) {
  ClayConfig config;
  config.spacing = spacing;
  config.gravity.setZero();
  config.budget = {substeps, iterations};
  config.threads = 1;
  return config;
}

std::vector<InitialParticle> toInitial(const std::vector<Eigen::Vector3f>& points) {
  std::vector<InitialParticle> particles;
  for (const Eigen::Vector3f& x : points) {
    InitialParticle p;
    p.position = x;
    p.velocity.setZero();
    particles.push_back(p);
  }
  return particles;
}

/// Largest rho / rho_0.
double densest(const VectorField& x) {
  const Kernel kernel(static_cast<float>(2.0 * spacing));
  Neighbourhood near(kernel.h);
  near.build(x);
  double largest = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    double total = kernel.sigma;
    for (std::uint32_t p = near.begin(i); p < near.begin(i) + near.count(i); ++p) {
      total += kernel.value(near.offset(p).norm());
    }
    largest = std::max(largest, total / latticeSum(kernel, static_cast<float>(spacing)));
  }
  return largest;
}

TEST(Constraint, DensityExpandsACompressedLattice) {
  Material m = nothing();
  m.bulk_modulus = 1e5;
  Clay clay(weightless(), {m}, toInitial(lattice(6, 0.95f * static_cast<float>(spacing), 0.0f)));
  const double before = densest(clay.particles().position);
  const auto [low, high] = extent(clay.particles(), Eigen::Vector3d::UnitX());
  ASSERT_GT(before, 1.1);
  clay.advance({}, {}, clay.config().frame);
  EXPECT_LT(densest(clay.particles().position) - 1.0, 0.5 * (before - 1.0));
  const auto [low_after, high_after] = extent(clay.particles(), Eigen::Vector3d::UnitX());
  EXPECT_GT(high_after - low_after, high - low);
}

TEST(Constraint, DensityLeavesAStretchedLatticeAlone) {
  Material m = nothing();
  m.bulk_modulus = 1e5;
  Clay clay(weightless(), {m}, toInitial(lattice(5, 1.1f * static_cast<float>(spacing), 0.0f)));
  clay.advance({}, {}, clay.config().frame);
  EXPECT_EQ(meanSpeed(clay.particles()), 0.0);
}

/// A block in uniform shear, v_x = rate z: after a frame the rate is less, the more the more viscous it is.
TEST(Constraint, ViscosityBrakesAShearFlow) {
  const auto rateAfter = [](double viscosity) {
    Material m = nothing();
    m.viscosity = viscosity;
    const float rate = 2.0f;
    auto particles = toInitial(lattice(6, static_cast<float>(spacing), 0.0f));
    for (InitialParticle& p : particles) p.velocity = {rate * p.position.z(), 0.0f, 0.0f};
    Clay clay(weightless(), {m}, particles);
    clay.advance({}, {}, clay.config().frame);
    // least squares fit of dv_x/dz + dv_z/dx, the strain rate (a rotation has none)
    double zz = 0.0, vz = 0.0, vx = 0.0;
    const Particles& p = clay.particles();
    for (std::size_t i = 0; i < p.size(); ++i) {
      const double x = particles[i].position.x(), z = particles[i].position.z();
      zz += z * z;
      vz += p.velocity[i].x() * z;
      vx += p.velocity[i].z() * x;
    }
    return (vz + vx) / zz / rate;
  };
  EXPECT_NEAR(rateAfter(0.0), 1.0, 1e-5);
  const double slightly = rateAfter(0.1), well = rateAfter(50.0);
  EXPECT_LT(slightly, 0.98);
  EXPECT_LT(well, 0.5 * slightly);
  EXPECT_GT(well, -0.1);
}

TEST(Constraint, BondsShortenWhatIsStretched) {
  Material m = nothing();
  m.stiffness = 1e4;
  m.bond_rate = 1e3;
  m.unbond_rate = 1e4;  // nothing breaks here
  const auto lengthsOf = [&m](double stiffness) {
    Material tested = m;
    tested.stiffness = stiffness;
    auto pair = toInitial({{0, 0, 0}, {static_cast<float>(spacing), 0, 0}});
    pair[1].velocity.x() = 0.2f;
    Clay clay(weightless(), {tested}, pair);
    std::vector<double> lengths;
    for (int k = 0; k < 40; ++k) {
      clay.advance({}, {}, clay.config().frame / 4);
      lengths.push_back((clay.particles().position.at(1) - clay.particles().position.at(0)).norm());
    }
    return lengths;
  };
  const auto loose = lengthsOf(0.0), bonded = lengthsOf(1e4);
  EXPECT_NEAR(loose[0], spacing + 0.2 / 240.0, 1e-7);
  EXPECT_LT(bonded[0], loose[0]);  // the bond formed at the start, at the pair's distance
  EXPECT_GT(bonded[0], spacing);
  EXPECT_LT(std::abs(bonded.back() - spacing), 0.05 * (bonded[0] - spacing));
}

TEST(Constraint, ImpenetrabilityPushesOutWithoutAJump) {
  for (const bool skin : {false, true}) {
    auto particle = toInitial({{0, 0, static_cast<float>(0.1 * spacing)}});
    ClayConfig config = weightless(4, 4);
    Clay clay(config, {nothing()}, particle);
    const Skin samples =
        skin ? samplePlane(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 0.02, 0.004) : Skin();
    const std::vector<Solid> solids = skin ? std::vector<Solid>() : std::vector<Solid>{ground()};
    double fastest = 0.0;
    const double recovery = skin ? 0.5 : 0.1;  // m/s
    const double step = config.frame / 4;
    const int steps = static_cast<int>(std::ceil(0.4 * spacing / (recovery * step)));
    for (int k = 0; k < steps; ++k) {
      clay.advance(samples, solids, step);
      fastest = std::max(fastest, meanSpeed(clay.particles()));
    }
    EXPECT_GE(clay.particles().position[0].z(), 0.5 * spacing - 1e-6);
    EXPECT_LE(fastest, recovery + 1e-3);
  }
}

TEST(Constraint, FrictionBrakesByMuG) {
  Material m = nothing();
  m.friction = 0.5;
  auto particle = toInitial({{0, 0, static_cast<float>(0.5 * spacing)}});
  particle[0].velocity.x() = 2.0f;
  ClayConfig config = weightless();
  config.gravity = {0.0, 0.0, -9.81};
  Clay clay(config, {m}, particle);
  clay.advance({}, {ground()}, 0.1);  // to get hold of the floor
  const double start = clay.particles().velocity[0].x(), time = clay.time();
  clay.advance({}, {ground()}, 0.2);
  const double braking = (start - clay.particles().velocity[0].x()) / (clay.time() - time);
  EXPECT_NEAR(braking, 0.5 * 9.81, 0.01 * 0.5 * 9.81);
  clay.advance({}, {ground()}, 0.3);
  EXPECT_NEAR(clay.particles().velocity[0].x(), 0.0, 1e-4);  // and then it rests
}

}  // namespace
}  // namespace tactile_clay::clay::constraints_test
