#include "clay/clay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "clay_frames.h"
#include "support/setups.h"

/// How clay moves: free fall, momentum, spin, compression, crumbs, bonds; and when its iterations stop.
namespace tactile_clay::clay::clay_test {
namespace {

using namespace clay_frames;

TEST(Clay, FallsFreely) {
  Clay clay(configOf(), {Material()}, block(5, 5, 5, spacing));
  const double start = centreOfMass(clay.particles()).z();
  run(clay, 12);
  // 48 steps of implicit Euler: v = -g t, x = -g (t^2 + t dt) / 2
  const double t = clay.time(), dt = 1.0 / 240.0;
  EXPECT_NEAR(t, 0.2, 1e-12);
  EXPECT_NEAR(centreOfMass(clay.particles()).z() - start, -0.5 * 9.81 * t * (t + dt), 1e-6);
  EXPECT_NEAR(momentum(clay.particles()).z(), -9.81 * t * totalMass(clay.particles()),
              1e-5 * 9.81 * t * totalMass(clay.particles()));
  EXPECT_LT(internalSpeed(clay.particles()), 1e-4);
}

TEST(Clay, ConservesMomentum) {
  auto particles = block(6, 6, 6, spacing);
  std::mt19937 random(1);
  std::normal_distribution<float> speed(0.0f, 0.1f);
  double size = 0.0;
  for (InitialParticle& p : particles) {
    for (int a = 0; a < 3; ++a) p.velocity[a] = speed(random);
  }
  ClayConfig config = configOf();
  config.gravity.setZero();
  Clay clay(config, {Material()}, particles);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    size += mass(clay.particles(), i) * clay.particles().velocity.at(i).norm();
  }
  const Eigen::Vector3d before = momentum(clay.particles());
  run(clay, 30);
  EXPECT_LT((momentum(clay.particles()) - before).norm(), 1e-5 * size);
}

/// Internal forces act along pairs, and so turn nothing.
TEST(Clay, KeepsSpinning) {
  auto particles = block(6, 6, 6, spacing);
  const Eigen::Vector3f spin(0.0f, 2.0f, 6.0f), centre(0.0f, 0.0f, static_cast<float>(3.0 * spacing));
  for (InitialParticle& p : particles) p.velocity = spin.cross(p.position - centre);
  ClayConfig config = configOf();
  config.gravity.setZero();
  Clay clay(config, {Material()}, particles);
  const Eigen::Vector3d before = angularMomentum(clay.particles());
  run(clay, 60);
  EXPECT_LT((angularMomentum(clay.particles()) - before).norm(), 1e-4 * before.norm());
}

/// Compression that no work was done for makes room, but no motion.
TEST(Clay, CompressionThatIsNotPaidForIsUndoneAtRest) {
  Material material;
  material.viscosity = material.stiffness = 0.0;
  ClayConfig config = configOf();
  config.gravity.setZero();
  Clay clay(config, {material}, block(6, 6, 6, 0.93 * spacing));
  Sculpture squeezed = clay.sculpture();
  std::fill(squeezed.compression.begin(), squeezed.compression.end(), 0.0f);
  clay.restore(squeezed);
  clay.advance({}, {}, config.frame / 4);
  const double before = clay.statistics().density_error_mean;  // as the step began
  run(clay, 2);
  EXPECT_LT(clay.statistics().density_error_mean, 0.1 * before);
  EXPECT_LT(meanSpeed(clay.particles()), 0.05);
}

/// Iterations stop when no particle lacks more acceleration than the tolerance. A block that settles needs
/// few iterations, a block at rest none, and the iterations that are left out move nothing.
TEST(Clay, IterationsStopUnderTheTolerance) {
  struct Settled {
    double iterations = 0.0, at_rest = 0.0;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  };
  const auto settle = [](double tolerance) {
    ClayConfig config = configOf();
    config.tolerance = tolerance;
    config.sleeping = false;
    Clay clay(config, {Material()}, block(6, 6, 6, spacing));
    Settled settled;
    for (int k = 0; k < 60; ++k) {
      clay.advance({}, {ground()}, config.frame);
      settled.iterations += clay.statistics().iterations;
    }
    settled.at_rest = clay.statistics().iterations;
    settled.centre = centreOfMass(clay.particles());
    const double top = 6.0 * spacing - 0.25 * spacing;
    const Skin palm = samplePlane({0.0, 0.0, top}, -Eigen::Vector3d::UnitZ(), 0.02, 0.003, {0.0, 0.0, -0.1});
    clay.advance(palm, {ground()}, config.frame);
    EXPECT_GE(clay.statistics().iterations, 0.75 * config.budget.iterations);
    return settled;
  };
  const Settled exact = settle(0.0), enough = settle(0.05);
  EXPECT_EQ(enough.at_rest, 0.0);
  EXPECT_LT(enough.iterations, 0.8 * exact.iterations);
  EXPECT_LT((enough.centre - exact.centre).norm(), 1e-3 * spacing);
}

/// A step starts from the whole turn of a lump, not from its tangent, so that a lump neither grows with each
/// step nor needs iterations to be pulled back. It grows by its centrifugal strain, of the order of rho
/// omega^2 R^2 / E.
TEST(Clay, ASpinningBlockKeepsItsSizeAtAnyBudget) {
  constexpr double omega = 12.0;  // rad/s
  const double radius = 3.0 * spacing;
  const auto size = [](const Particles& p) {  // about the axis
    double sum = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) sum += p.position.at(i).head<2>().squaredNorm();
    return std::sqrt(sum / static_cast<double>(p.size()));
  };
  for (const int iterations : {1, 2, 4, 8}) {
    auto particles = block(6, 6, 6, spacing);
    for (InitialParticle& p : particles) p.velocity = Eigen::Vector3f(0, 0, omega).cross(p.position);
    ClayConfig config = configOf();
    config.gravity.setZero();
    config.budget = {4, iterations};
    const Material material;
    Clay clay(config, {material}, particles);
    const double before = size(clay.particles());
    run(clay, 120);
    const double strain = material.density * std::pow(omega * radius, 2.0) / material.stiffness;
    EXPECT_NEAR(size(clay.particles()) / before, 1.0, 0.5 * strain) << iterations << " iterations";
  }
}

TEST(Clay, KeepsSpinningWithoutViscosity) {
  auto particles = block(6, 6, 6, spacing);
  const Eigen::Vector3f spin(0.0f, 2.0f, 6.0f), centre(0.0f, 0.0f, static_cast<float>(3.0 * spacing));
  for (InitialParticle& p : particles) p.velocity = spin.cross(p.position - centre);
  ClayConfig config = configOf();
  config.gravity.setZero();
  Material elastic;
  elastic.viscosity = 0.0;
  Clay clay(config, {elastic}, particles);
  const Eigen::Vector3d before = angularMomentum(clay.particles());
  run(clay, 60);
  EXPECT_LT((angularMomentum(clay.particles()) - before).norm(), 1e-4 * before.norm());
}

/// Bonds left of a pair that is set going at `rate` (1/s, of its length) and watched for two frames.
std::size_t bondsOfPair(double rate, double stiffness, int substeps) {
  Material material;
  material.viscosity = material.bulk_modulus = 0.0;
  material.stiffness = stiffness;
  material.bond_rate = 1.0;
  material.unbond_rate = 10.0;
  material.yield_strain = 2.0;
  ClayConfig config = configOf(substeps, 8);
  config.gravity.setZero();
  const float half = static_cast<float>(0.5 * rate * spacing);
  Clay clay(config, {material},
            {{{0, 0, 0}, {-half, 0, 0}, 0, 0}, {{static_cast<float>(spacing), 0, 0}, {half, 0, 0}, 0, 0}});
  run(clay, 2);
  return clay.statistics().bonds;
}

/// Lumps do not interact: a force on one lump moves no other, however few iterations there are. With one
/// common step along a direction for all lumps, a crumb was moved as the block was.
TEST(Clay, ACrumbSlidesAsIfNoBlockWereCrushed) {
  const auto wayOfCrumb = [](bool beside) {
    std::vector<InitialParticle> particles;
    if (beside) particles = block(6, 6, 6, spacing);
    InitialParticle crumb;
    crumb.position = {0.0f, 0.2f, static_cast<float>(0.5 * spacing)};
    crumb.velocity = {2.0f, 0.0f, 0.0f};
    particles.push_back(crumb);
    Clay clay(configOf(4, 6), {Material()}, particles);
    for (int k = 0; k < 12; ++k) {
      const double down = 2.0, height = 0.08 - down * clay.config().frame * k;
      const Eigen::Vector3d at(0.0, 0.0, std::max(height, 0.5 * spacing));
      clay.advance(samplePlane(at, -Eigen::Vector3d::UnitZ(), 0.03, 0.004, {0.0, 0.0, -down}), {ground()},
                   clay.config().frame);
    }
    return clay.particles().position.at(particles.size() - 1).x();
  };
  const double alone = wayOfCrumb(false);
  EXPECT_GT(alone, 0.1);
  EXPECT_NEAR(wayOfCrumb(true), alone, 1e-3 * alone);
}

TEST(Clay, BondsPartByWhatAFrameDoesHoweverItIsCut) {
  for (const int substeps : {1, 4, 16, 64}) {
    EXPECT_EQ(bondsOfPair(9.0, 1e-3, substeps), 1u) << substeps;
    EXPECT_EQ(bondsOfPair(13.0, 1e-3, substeps), 0u) << substeps;
    // One that vibrates by 5 % of its length, at velocities of twice the rate.
    EXPECT_EQ(bondsOfPair(20.0, 3200.0, substeps), 1u) << substeps;
  }
}

}  // namespace
}  // namespace tactile_clay::clay::clay_test
