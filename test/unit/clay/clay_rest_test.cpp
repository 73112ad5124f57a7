#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "clay/clay.h"
#include "clay_frames.h"
#include "support/setups.h"

/// Clay comes to rest, and presses on the table and on the skin with the forces of mechanics.
namespace tactile_clay::clay::clay_rest_test {
namespace {

using namespace clay_frames;

class AtBudget : public ::testing::TestWithParam<std::pair<int, int>> {};

void expectDeadRest(int edge, int substeps, int iterations) {
  Clay clay(configOf(substeps, iterations), {Material()}, block(edge, edge, edge, spacing));
  const double weight = 9.81 * totalMass(clay.particles());
  run(clay, 40, {}, {ground()});
  EXPECT_NEAR(-clay.solidForces()[0].z(), weight, 1e-3 * weight) << edge << " particles high";
  EXPECT_LT(clay.solidForces()[0].head<2>().norm(), 1e-3 * weight);
  EXPECT_LT(meanSpeed(clay.particles()), 1e-5) << edge << " particles high";
  EXPECT_GT(extent(clay.particles(), Eigen::Vector3d::UnitZ()).second, 0.98 * (edge - 0.5) * spacing);
}

TEST_P(AtBudget, ARestingBlockPressesWithItsWeightAndIsDeadStill) {
  expectDeadRest(5, GetParam().first, GetParam().second);
}

/// At the presets `fast` and `balanced`.
TEST(Clay, AnyCubeComesToRest) {
  for (const int edge : {4, 5, 6, 7, 8, 9, 10, 12}) {
    expectDeadRest(edge, 4, 6);
    expectDeadRest(edge, 4, 8);
  }
}

TEST(Clay, FourIterationsBringAnyCubeToRest) {
  for (const int edge : {4, 5, 6, 7, 8, 10}) expectDeadRest(edge, 4, 4);
}

/// A thumb has left a dent and a rim that stands off the ground. The block comes to rest, however stiff it is
/// and however few the iterations: a step gains no energy (without the first direction of `descend` it buzzes
/// at 30 mm/s).
TEST(Clay, ADentedBlockComesToRest) {
  for (const double viscosity : {0.0, 50.0, 200.0, 1000.0, 1e4}) {
    for (const int iterations : {4, 6, 8}) {
      Material material;
      material.viscosity = viscosity;
      Clay clay(configOf(4, iterations), {material}, block(5, 5, 5, spacing));
      for (int k = 1; k <= 48; ++k) {
        const double depth = 0.02 * std::sin(k * M_PI / 48.0),
                     before = 0.02 * std::sin((k - 1) * M_PI / 48.0);
        const Eigen::Vector3d velocity(0.0, 0.0, -60.0 * (depth - before));
        clay.advance(
            samplePlane({0.0, 0.0, 0.037 - depth}, -Eigen::Vector3d::UnitZ(), 0.006, 0.003, velocity),
            {ground()}, 1.0 / 60.0);
      }
      run(clay, 180, {}, {ground()});
      EXPECT_LT(meanSpeed(clay.particles()), 1e-5) << viscosity << " Pa s, " << iterations << " iterations";
    }
  }
}

TEST_P(AtBudget, ASkinCarriesARestingBlock) {
  Clay clay(configOf(GetParam().first, GetParam().second), {Material()}, block(5, 5, 5, spacing));
  const Skin palm = samplePlane(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 0.03, 0.004);
  const double weight = 9.81 * totalMass(clay.particles());
  run(clay, 40, palm);
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const SkinForce& f : clay.skinForces()) force += f.force.cast<double>();
  EXPECT_NEAR(-force.z(), weight, 1e-3 * weight);
  EXPECT_LT(force.head<2>().norm(), 1e-3 * weight);
  EXPECT_LT(meanSpeed(clay.particles()), 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Budgets, AtBudget,
                         ::testing::Values(std::pair{4, 4}, std::pair{4, 8}, std::pair{8, 16}));

Eigen::Vector3d sumOf(const std::vector<SkinForce>& forces) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const SkinForce& f : forces) sum += f.force.cast<double>();
  return sum;
}

/// Newton's third law through the clay: the table feels the force of the palm plus the weight, and the
/// difference is the rate of momentum.
TEST(Clay, ForcesOnPalmAndTableAreTheRateOfMomentum) {
  Material soft;
  soft.yield_strain = 0.05;
  Clay clay(configOf(), {soft}, block(6, 6, 6, spacing));
  const double weight = 9.81 * totalMass(clay.particles()), speed = 0.02;
  double strongest = 0.0;
  for (int k = 1; k <= 20; ++k) {
    const double before = momentum(clay.particles()).z(), z = 0.03 - speed * clay.config().frame * k;
    clay.advance(samplePlane({0.0, 0.0, z}, -Eigen::Vector3d::UnitZ(), 0.024, 0.004, {0.0, 0.0, -speed}),
                 {ground()}, clay.config().frame);
    std::int64_t last = -1;
    for (const SkinForce& f : clay.skinForces()) {
      ASSERT_LT(last, f.index) << "not by ascending sample";
      last = f.index;
    }
    const double palm = sumOf(clay.skinForces()).z(), table = clay.solidForces()[0].z();
    const double change = (momentum(clay.particles()).z() - before) / clay.config().frame;
    if (k > 2) {
      EXPECT_NEAR(palm + table + change, -weight, 0.01 * palm) << "frame " << k;  // all on the surroundings
    }
    strongest = std::max(strongest, palm);
  }
  EXPECT_GT(strongest, 5.0);
}

/// Few iterations leave much of an impact unsolved; the impulse on the skin is the momentum of the block all
/// the same.
TEST(Clay, AnImpactOnTheSkinIsTheRateOfMomentum) {
  ClayConfig config = configOf();
  config.gravity.setZero();
  Clay clay(config, {Material()}, block(5, 5, 5, spacing));
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
  for (int k = 1; k <= 12; ++k) {
    const Eigen::Vector3d velocity(0.02, 0.0, 0.1), start(0.0, 0.0, -0.014);
    clay.advance(sampleBall(start + k * config.frame * velocity, 0.015, 0.004, velocity), {}, config.frame);
    impulse += config.frame * sumOf(clay.skinForces());
  }
  EXPECT_LT((impulse + momentum(clay.particles())).norm(), 1e-3 * momentum(clay.particles()).norm());
}

/// Without friction a block keeps its place over skin that is drawn away below it: the slip is the speed of
/// the skin. With a little, mu, it is drawn along at mu g (Coulomb); with much of it nothing slides.
TEST(Clay, SlipIsTheSpeedAtWhichClaySlidesAlongTheSkin) {
  const double speed = 0.05;  // m/s
  for (const double friction : {0.0, 0.01, 5.0}) {
    Material material;
    material.skin_friction = friction;
    Clay clay(configOf(), {material}, block(5, 5, 5, spacing));
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    run(clay, 40, samplePlane(centre, Eigen::Vector3d::UnitZ(), 0.04, 0.004));
    for (const SkinForce& f : clay.skinForces()) EXPECT_LT(f.slip, 1e-3) << "at rest";
    for (int k = 0; k < 15; ++k) {
      centre.x() += speed * clay.config().frame;
      clay.advance(samplePlane(centre, Eigen::Vector3d::UnitZ(), 0.04, 0.004, {speed, 0.0, 0.0}), {},
                   clay.config().frame);
    }
    ASSERT_FALSE(clay.skinForces().empty());
    double force = 0.0, slip = 0.0;
    for (const SkinForce& f : clay.skinForces()) {
      force += f.force.norm();
      slip += f.force.norm() * f.slip;
    }
    const double middle = 14.5 * clay.config().frame;  // s, of the last frame
    EXPECT_NEAR(slip / force, std::max(speed - friction * 9.81 * middle, 0.0), 0.05 * speed)
        << "friction " << friction;
  }
}

}  // namespace
}  // namespace tactile_clay::clay::clay_rest_test
