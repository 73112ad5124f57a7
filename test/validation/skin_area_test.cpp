// The skin's area against that of the union of capsules.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "hand/hand_shape.h"
#include "hand/skin_template.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;

constexpr double spacing = 5e-3;  // m

// Area of the union by Minkowski's definition: volume of the shell outside it within h, over h, extrapolated
// to h = 0 from two thicknesses (Steiner: A h + H h^2).
double monteCarloArea(const TrackedHand& hand) {
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity());
  Vector3d high = -low;
  for (const JointPose& joint : hand.joints) {
    low = low.cwiseMin(joint.position.array().matrix() - Vector3d::Constant(joint.radius + 0.003));
    high = high.cwiseMax(joint.position + Vector3d::Constant(joint.radius + 0.003));
  }
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  constexpr int count = 400000;
  int thin = 0;
  int thick = 0;
  for (int i = 0; i < count; ++i) {
    const Vector3d point = low + Vector3d(unit(random), unit(random), unit(random)).cwiseProduct(high - low);
    const double distance = handDistance(hand, point);
    thin += distance > 0.0 && distance < 1e-3;
    thick += distance > 0.0 && distance < 2e-3;
  }
  const double volume = (high - low).prod() / count;
  return 2.0 * thin * volume / 1e-3 - thick * volume / 2e-3;
}

TEST(Skin, AreasSumToTheUnionSurface) {
  for (const double scale : {0.8, 1.05}) {
    const SkinTemplate skin = makeSkinTemplate(Side::right, scale, spacing);
    double area = 0.0;
    for (const BoundSample& sample : skin.samples) area += sample.area;
    const double truth = monteCarloArea(restHand(Side::right, scale));
    EXPECT_NEAR(area, truth, 0.05 * truth) << "scale " << scale;
  }
}

// The finest that a user is likely to ask for.
TEST(Skin, FineSpacingIsConnectedAndPositive) {
  for (const BoundSample& sample : makeSkinTemplate(Side::left, 1.0, 2.5e-3).samples) {
    EXPECT_TRUE(std::isfinite(sample.pad_distance));
    EXPECT_GT(sample.area, 0.0F);
  }
}

}  // namespace
}  // namespace tactile_clay::hand
