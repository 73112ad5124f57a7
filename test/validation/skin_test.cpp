// The skin against the union of capsules: area, and no bare patch.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <random>

#include "hand/anatomy.h"
#include "hand/hand_pose.h"
#include "hand/hand_shape.h"
#include "hand/kinematic_hand.h"
#include "hand/skin_template.h"

namespace tactile_clay::hand::skin_test {
namespace {

using Eigen::Vector3d;
using std::chrono::nanoseconds;

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
    for (std::size_t i = 0; i < skin.bare_at_rest; ++i) area += skin.samples[i].area;
    const double truth = monteCarloArea(restHand(Side::right, scale));
    EXPECT_NEAR(area, truth, 0.05 * truth) << "scale " << scale;
  }
}

// Farthest that bare points of the bones' capsules are from a sample, m.
double barest(const TrackedHand& hand, const Skin& skin) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  double worst = 0.0;
  for (const Bone& bone : bones) {
    const Capsule capsule = boneCapsule(bone, hand);
    for (int i = 0; i < 300; ++i) {
      const double u = unit(random);
      const Vector3d direction = Vector3d(normal(random), normal(random), normal(random)).normalized();
      Vector3d point = capsule.centre(u) + 0.1 * direction;
      while (capsule.distance(point) > 1e-6) point -= capsule.distance(point) * direction;
      if (handDistance(hand, point) < -1e-5) continue;
      double closest = 1.0;
      for (const Eigen::Vector3f& x : skin.position)
        closest = std::min(closest, (x.cast<double>() - point).norm());
      worst = std::max(worst, closest);
    }
  }
  return worst;
}

// Far from the pose in which the skin was sampled, samples near knuckles leave the capsules by the error of
// blending, and folded skin is buried. All other samples must lie on the surface, and the surface must have
// no bare patch.
TEST(Skin, FlatHandAndFistStayCovered) {
  for (const double bend : {0.0, 1.4}) {
    HandPose pose;
    pose.scale = 1.05;
    for (int finger = 1; finger < finger_count; ++finger)
      pose.fingers[finger].flexion = {bend, bend, 0.8 * bend};
    const TrackedHand hand = forwardKinematics(pose);
    KinematicHands hands(spacing);
    const Skin skin = hands.update({hand}, nanoseconds(0));
    int outside = 0;
    int off = 0;
    for (std::size_t i = 0; i < skin.size(); ++i) {
      const double distance = handDistance(hand, skin.position[i].cast<double>());
      EXPECT_LT(distance, 1e-3) << bend;
      off += distance > 2e-4;
      outside += distance > -2e-3;
    }
    EXPECT_LT(off, 0.02 * static_cast<double>(skin.size())) << bend;
    EXPECT_GT(outside, 0.8 * static_cast<double>(skin.size())) << bend;
    EXPECT_LT(barest(hand, skin), 1.1 * spacing) << bend;
  }
}

// Discs with the radius of a spacing about the samples decide what is beneath the skin. In the pose in which
// they were chosen, samples are at most 0.8 spacings apart; knuckles stretch this distance.
TEST(Skin, NoPoseLeavesAnythingBare) {
  KinematicHands hands(spacing);
  std::mt19937 random(6);
  const auto within = [&](const Eigen::Vector2d& range) {
    return std::uniform_real_distribution<double>(range.x(), range.y())(random);
  };
  double worst = 0.0;
  for (int k = 0; k < 60; ++k) {
    SCOPED_TRACE(k);
    HandPose pose;
    pose.side = k % 2 == 0 ? Side::left : Side::right;
    pose.scale = 1.05;
    for (int finger = 0; finger < finger_count; ++finger) {
      for (int joint = 0; joint < 3; ++joint)
        pose.fingers[finger].flexion[joint] = within(finger_limits[finger].flexion[joint]);
      pose.fingers[finger].abduction = within(finger_limits[finger].abduction);
    }
    const TrackedHand hand = forwardKinematics(pose);
    const double barest_here = barest(hand, hands.update({hand}, nanoseconds(0)));
    EXPECT_LT(barest_here, 1.1 * spacing);
    worst = std::max(worst, barest_here);
  }
  RecordProperty("worst_um", static_cast<int>(1e6 * worst));
}

// Tracked thumbs reach farther out than the range of the tables.
TEST(Skin, AnyThumbLeavesNothingBare) {
  KinematicHands hands(spacing);
  for (const Side side : {Side::left, Side::right})
    for (const double abduction : {-0.6, -0.45, -0.2, 0.2, 0.35})
      for (const double flexion : {-0.09, 0.3, 0.61}) {
        HandPose pose;
        pose.side = side;
        pose.scale = 1.05;
        pose.fingers[0].abduction = abduction;
        pose.fingers[0].flexion[0] = flexion;
        const TrackedHand hand = forwardKinematics(pose);
        EXPECT_LT(barest(hand, hands.update({hand}, nanoseconds(0))), 1.1 * spacing)
            << (side == Side::left ? "left " : "right ") << abduction << ' ' << flexion;
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
}  // namespace tactile_clay::hand::skin_test
