#include <gtest/gtest.h>

#include "support/setups.h"

/// A flat fingertip of 20 x 20 mm is pressed into a block at 40 mm/s and held: the haptic force.
namespace tactile_clay::clay::indentation_test {
namespace {

constexpr double speed = 0.04, pitch = 0.0025, half = 0.01;
constexpr double area = 4.0 * (half + 0.5 * pitch) * (half + 0.5 * pitch);

/// Mean pressure on the fingertip, Pa.
struct Press {
  double at_depth = 0.0;  // in the frame in which it arrives
  double held = 0.0;      // half a second later
};

Press press(const Material& material, double depth, Budget budget = {4, 8}) {
  ClayConfig config;
  config.budget = budget;
  config.threads = 2;
  Clay clay(config, {material}, block(8, 8, 8, config.spacing));
  for (int k = 0; k < 10; ++k) clay.advance({}, {ground()}, config.frame);
  const auto pressure = [&] {
    double force = 0.0;
    for (const SkinForce& f : clay.skinForces()) force += f.force.z();
    return force / area;
  };
  Press result;
  const int frames = static_cast<int>(std::lround(depth / speed / config.frame));
  for (int k = 1; k <= frames + 30; ++k) {
    const double z = 0.04 - depth * std::min(k, frames) / frames;
    const Eigen::Vector3d velocity(0.0, 0.0, k <= frames ? -depth / frames / config.frame : 0.0);
    clay.advance(samplePlane({0.0, 0.0, z}, -Eigen::Vector3d::UnitZ(), half, pitch, velocity), {ground()},
                 config.frame);
    if (k == frames) result.at_depth = pressure();
  }
  result.held = pressure();
  return result;
}

Material plastic(double yield_strain, double unbond_rate) {
  Material m;
  m.yield_strain = yield_strain;
  m.unbond_rate = unbond_rate;
  return m;
}

TEST(Indentation, PressesHarderTheDeeper) {
  const Material clay = plastic(0.05, 10.0);
  const Press shallow = press(clay, 0.002), middle = press(clay, 0.004), deep = press(clay, 0.008);
  EXPECT_GT(shallow.at_depth, 100.0);
  EXPECT_GT(middle.at_depth, 1.2 * shallow.at_depth);
  EXPECT_GT(deep.at_depth, 1.1 * middle.at_depth);
  EXPECT_GT(middle.held, shallow.held);
  EXPECT_GT(deep.held, middle.held);
}

/// Fig. 6 of the paper: the less plastic, the higher the pressure on the hand.
TEST(Indentation, LessPlasticityMeansMorePressure) {
  const Press soft = press(plastic(0.02, 5.0), 0.006), middle = press(plastic(0.06, 10.0), 0.006),
              elastic = press(plastic(0.3, 50.0), 0.006);
  EXPECT_GT(middle.at_depth, 1.2 * soft.at_depth);
  EXPECT_GT(elastic.at_depth, 1.2 * middle.at_depth);
  EXPECT_GT(middle.held, 1.2 * soft.held);
  EXPECT_GT(elastic.held, 1.2 * middle.held);
}

void expectLikeTheReference(const Material& clay, Budget reference_budget) {
  const Press balanced = press(clay, 0.006, {4, 8}), reference = press(clay, 0.006, reference_budget);
  EXPECT_NEAR(balanced.at_depth, reference.at_depth, 0.1 * reference.at_depth);
  EXPECT_NEAR(balanced.held, reference.held, 0.1 * reference.held);
}

/// If only yield matters, the force depends on the material, not on the budget.
TEST(Indentation, DependsLittleOnTheBudget) {
  expectLikeTheReference(plastic(0.05, 1000.0), {16, 32});
}

/// At the rim of the fingertip pairs stretch at 8/s, close to the threshold of 10/s. When the finger stops at
/// once, bonds that flowed must not stay weaker for one more step: clay would move in, and the finger would
/// press with 17 % less than in the reference.
TEST(Indentation, DependsLittleOnTheBudgetWhereBondsBreak) {
  expectLikeTheReference(plastic(0.05, 10.0), {32, 32});
}

}  // namespace
}  // namespace tactile_clay::clay::indentation_test
