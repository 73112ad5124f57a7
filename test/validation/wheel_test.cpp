#include <gtest/gtest.h>

#include "support/setups.h"

/// Clay that rests on a turning wheel turns with it, and neither grows nor creeps outwards.
namespace tactile_clay::clay::wheel_test {
namespace {

constexpr double spacing = 0.005, g = 9.81;

/// Root mean square distance from the axis, m.
double gyration(const Particles& p) {
  double sum = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) sum += p.position.at(i).head<2>().cast<double>().squaredNorm();
  return std::sqrt(sum / static_cast<double>(p.size()));
}

class PottersWheel : public ::testing::TestWithParam<int> {};
TEST_P(PottersWheel, CarriesTheClayAlong) {
  constexpr double rate = 2.0 * M_PI, seconds = 10.0;  // rad/s: 60 rpm
  ClayConfig config;
  config.budget = {4, GetParam()};
  config.threads = 2;
  auto particles = block(8, 8, 6, spacing);
  for (InitialParticle& p : particles)
    p.velocity = static_cast<float>(rate) * Eigen::Vector3f::UnitZ().cross(p.position);
  Clay clay(config, {Material()}, particles);
  Solid wheel;
  wheel.shape = Solid::Shape::cylinder;
  wheel.size = {0.1, 0.01, 0.0};
  wheel.pose.translation().z() = -0.01;
  wheel.angular_velocity.z() = rate;
  const double first = gyration(clay.particles()), weight = g * totalMass(clay.particles());
  double angle = 0.0;  // turned by the first particle
  for (int k = 0; k < std::lround(seconds / config.frame); ++k) {
    const Eigen::Vector3d before = clay.particles().position.at(0).cast<double>();
    clay.advance({}, {wheel}, config.frame);
    wheel.pose = poseAfter(wheel, config.frame);
    const Eigen::Vector3d after = clay.particles().position.at(0).cast<double>();
    angle +=
        std::atan2(before.x() * after.y() - before.y() * after.x(), before.head<2>().dot(after.head<2>()));
    EXPECT_NEAR(-clay.solidForces()[0].z(), weight, 0.01 * weight) << "frame " << k;
  }
  EXPECT_NEAR(angle, rate * seconds, 0.01 * rate * seconds);
  EXPECT_NEAR(gyration(clay.particles()), first, 1e-3 * first);
}
INSTANTIATE_TEST_SUITE_P(Iterations, PottersWheel, ::testing::Values(4, 8));

}  // namespace
}  // namespace tactile_clay::clay::wheel_test
