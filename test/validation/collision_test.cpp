#include <gtest/gtest.h>

#include "support/setups.h"

/// Newton: two pieces of different clay meet in free space.
namespace tactile_clay::clay::collision_test {
namespace {

TEST(Collision, KeepsMomentumAndGainsNoEnergy) {
  constexpr double spacing = 0.005;
  Material firm, soft;
  firm.density = 2000.0;
  soft.stiffness = 1e4;
  soft.viscosity = 50.0;
  soft.density = 1000.0;
  auto particles = block(6, 6, 6, spacing, {-0.021, 0.0, 0.0});
  for (InitialParticle& p : particles) p.velocity = {0.4f, 0.0f, 0.0f};
  auto other = block(6, 6, 6, spacing, {0.021, 0.006, 0.004},
                     Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix(), 1);
  for (InitialParticle& p : other) p.velocity = {-0.4f, 0.0f, 0.0f};
  particles.insert(particles.end(), other.begin(), other.end());
  ClayConfig config;
  config.gravity.setZero();
  config.threads = 2;
  Clay clay(config, {firm, soft}, particles);

  const Eigen::Vector3d start = momentum(clay.particles());
  const double exchanged = 0.4 * totalMass(clay.particles());  // scale of what the pieces give each other
  double energy = kineticEnergy(clay.particles());
  const double first = energy;
  for (int k = 0; k < 40; ++k) {
    clay.advance({}, {}, config.frame);
    EXPECT_LT((momentum(clay.particles()) - start).norm(), 1e-5 * exchanged);
    const double now = kineticEnergy(clay.particles());
    EXPECT_LT(now, first * 1.001);
    energy = now;
  }
  EXPECT_LT(energy, 0.5 * first);  // they met
}

}  // namespace
}  // namespace tactile_clay::clay::collision_test
