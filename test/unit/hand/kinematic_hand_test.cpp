#include "hand/kinematic_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <random>
#include <stdexcept>
#include <utility>

#include "hand/anatomy.h"
#include "hand/hand_pose.h"
#include "hand/hand_shape.h"
#include "hand/skin_template.h"

namespace tactile_clay::hand::kinematic_hand_test {
namespace {

using Eigen::Vector3d;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr double spacing = 5e-3, coarse = 8e-3;  // m

TrackedHand flatHand(Side side, double scale = 1.05) {
  HandPose pose;
  pose.side = side;
  pose.scale = scale;
  return forwardKinematics(pose);
}

void transform(TrackedHand& hand, const Eigen::Isometry3d& motion) {
  for (JointPose& joint : hand.joints) {
    joint.position = motion * joint.position;
    joint.orientation = Eigen::Quaterniond(motion.rotation()) * joint.orientation;
  }
}

double totalArea(const Skin& skin) {
  double sum = 0.0;
  for (const float area : skin.area) sum += area;
  return sum;
}

TEST(Capsule, NoPointWithinADistanceIsLeftOut) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-0.03, 0.03), radius(0.002, 0.012);
  const auto point = [&] { return Vector3d(any(random), any(random), any(random)); };
  int outside = 0;
  for (int k = 0; k < 2000; ++k) {
    const Capsule capsule{point(), point(), radius(random), radius(random)};
    const Vector3d x = point();
    for (const double within : {0.0, 0.002})
      EXPECT_TRUE(capsule.distance(x) > within || capsule.mayBeWithin(within, x)) << k;
    outside += capsule.mayBeWithin(0.0, x) ? 0 : 1;
  }
  EXPECT_GT(outside, 200);
}

TEST(KinematicHand, PalmHasNoHoleBetweenMetacarpals) {
  const TrackedHand hand = flatHand(Side::right);
  for (int finger = 1; finger + 1 < finger_count; ++finger)
    for (double u = 0.0; u <= 1.0; u += 0.05)
      for (double v = 0.0; v <= 1.0; v += 0.1) {
        const auto at = [&](int f) {
          return Vector3d((1.0 - u) * hand.joints[fingers[f][0]].position +
                          u * hand.joints[fingers[f][1]].position);
        };
        EXPECT_LT(handDistance(hand, (1.0 - v) * at(finger) + v * at(finger + 1)), 0.0)
            << finger << " " << u << " " << v;
      }
}

TEST(KinematicHand, SamplesLieOnTheSkinAndNormalsLeaveIt) {
  const TrackedHand hand = restHand(Side::left, 1.05);
  KinematicHands hands(spacing);
  const Skin skin = hands.update({hand}, nanoseconds(0));
  const std::size_t bare = makeSkinTemplate(Side::left, 1.05, spacing).bare_at_rest;
  ASSERT_GT(bare, 1000U);
  for (std::size_t i = 0; i < bare; ++i) {
    const Vector3d x = skin.position[i].cast<double>();
    const Vector3d n = skin.normal[i].cast<double>();
    EXPECT_NEAR(n.norm(), 1.0, 1e-5);
    EXPECT_NEAR(handDistance(hand, x), 0.0, 2e-6) << i;
    EXPECT_GT(handDistance(hand, x + 1e-4 * n), 2e-5) << i;
    EXPECT_LT(handDistance(hand, x - 1e-4 * n), 0.0) << i;
  }
}

// Skin that bones cover is still there, but so deep that it touches no clay outside.
TEST(KinematicHand, CoveredSamplesWithdrawAndComeOutWithTheThumb) {
  const std::size_t bare = makeSkinTemplate(Side::right, 1.05, spacing).bare_at_rest;
  for (const Side side : {Side::left, Side::right}) {
    KinematicHands hands(spacing);
    const TrackedHand rest = restHand(side, 1.05);
    const Skin covered = hands.update({rest}, nanoseconds(0));
    ASSERT_GT(covered.size(), bare + 20);
    int deep = 0;
    for (std::size_t i = bare; i < covered.size(); ++i) {
      const double distance = handDistance(rest, covered.position[i].cast<double>());
      EXPECT_LT(distance, 1e-6) << i;
      deep += distance < -spacing ? 1 : 0;
    }
    EXPECT_GT(deep, 0.7 * static_cast<double>(covered.size() - bare));
    HandPose pose;
    pose.side = side;
    pose.scale = 1.05;
    pose.fingers[0].abduction = -0.6;
    const TrackedHand out = forwardKinematics(pose);
    const Skin skin = hands.update({out}, nanoseconds(0));
    int on_the_skin = 0;
    for (std::size_t i = bare; i < skin.size(); ++i) {
      const bool on = std::abs(handDistance(out, skin.position[i].cast<double>())) < 1e-4;
      on_the_skin += on ? 1 : 0;
      if (on) {
        EXPECT_GT(skin.area[i], 0.0F);
      }
    }
    EXPECT_GT(on_the_skin, 10);
  }
}

TEST(KinematicHand, RigidMotionGivesRigidVelocity) {
  KinematicHands hands(coarse);
  TrackedHand hand = flatHand(Side::right);
  const Skin before = hands.update({hand}, milliseconds(1000));
  for (const Eigen::Vector3f& v : before.velocity) EXPECT_EQ(v, Eigen::Vector3f::Zero().eval());
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = Eigen::AngleAxisd(0.02, Vector3d(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
  motion.translation() = Vector3d(0.003, -0.001, 0.002);
  transform(hand, motion);
  const Skin after = hands.update({hand}, milliseconds(1010));
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    const Vector3d x = before.position[i].cast<double>();
    const Vector3d expected = (motion * x - x) / 0.01;
    EXPECT_LT((after.velocity[i].cast<double>() - expected).norm(), 2e-5);
    EXPECT_LT((after.normal[i].cast<double>() - motion.rotation() * before.normal[i].cast<double>()).norm(),
              1e-5);
  }
}

TEST(KinematicHand, VelocityIsZeroAfterLossJumpFlipAndStandingClock) {
  const auto fastest = [](const Skin& skin) {
    float maximum = 0.0F;
    for (const Eigen::Vector3f& v : skin.velocity) maximum = std::max(maximum, v.norm());
    return maximum;
  };
  KinematicHands hands(coarse);
  TrackedHand hand = flatHand(Side::right);
  const auto moveBy = [&](double x) {
    transform(hand, Eigen::Isometry3d(Eigen::Translation3d(x, 0.0, 0.0)));
  };
  hands.update({hand}, milliseconds(0));
  moveBy(0.01);
  EXPECT_NEAR(fastest(hands.update({hand}, milliseconds(10))), 1.0F, 1e-3F);
  moveBy(0.01);
  EXPECT_EQ(fastest(hands.update({hand}, milliseconds(10))), 0.0F);  // same stamp
  moveBy(0.01);
  EXPECT_EQ(fastest(hands.update({hand}, milliseconds(5))), 0.0F);  // stamp went back
  moveBy(0.6);
  EXPECT_EQ(fastest(hands.update({hand}, milliseconds(20))), 0.0F);  // jump
  const auto turnBy = [&](double angle) {
    const Vector3d centre = hand.joints[palm].position;
    transform(hand, Eigen::Translation3d(centre) * Eigen::AngleAxisd(angle, Vector3d::UnitZ()) *
                        Eigen::Translation3d(-centre));
  };
  turnBy(M_PI);
  EXPECT_EQ(fastest(hands.update({hand}, milliseconds(22))), 0.0F);  // a tracker that takes left for right
  turnBy(1.0);
  EXPECT_GT(fastest(hands.update({hand}, milliseconds(24))), 1.0F);
  EXPECT_EQ(hands.update({}, milliseconds(30)).size(), 0U);
  moveBy(0.01);
  EXPECT_EQ(fastest(hands.update({hand}, milliseconds(40))), 0.0F);  // lost in between
  moveBy(0.01);
  EXPECT_NEAR(fastest(hands.update({hand}, milliseconds(50))), 1.0F, 1e-3F);
}

TEST(KinematicHand, IndicesAreStableWhileTheTrackerRescalesThePerson) {
  KinematicHands hands(coarse);
  const Skin first = hands.update({flatHand(Side::right, 1.0)}, milliseconds(0));
  const Skin second = hands.update({flatHand(Side::right, 1.04)}, milliseconds(10));
  ASSERT_EQ(first.size(), second.size());
  EXPECT_EQ(first.region, second.region);
  for (std::size_t i = 0; i < first.size(); ++i)
    EXPECT_LT((second.position[i] - 1.04F * first.position[i]).norm(), 1e-6F);
  EXPECT_NEAR(totalArea(second) / totalArea(first), 1.04 * 1.04, 1e-4);
}

TEST(KinematicHand, AnotherPersonIsSampledAnew) {
  KinematicHands hands(coarse);
  const std::size_t adult = hands.update({flatHand(Side::right, 1.05)}, milliseconds(0)).size();
  hands.update({}, milliseconds(10));
  const std::size_t child = hands.update({flatHand(Side::right, 0.7)}, milliseconds(20)).size();
  EXPECT_NEAR(static_cast<double>(child) / static_cast<double>(adult), std::pow(0.7 / 1.05, 2), 0.05);
}

TEST(KinematicHand, LeftComesFirstAndIsTheMirrorImageOfRight) {
  KinematicHands hands(coarse);
  const Skin skin = hands.update({flatHand(Side::right), flatHand(Side::left)}, nanoseconds(0));
  ASSERT_EQ(skin.size() % 2, 0U);
  const std::size_t half = skin.size() / 2;
  for (std::size_t i = 0; i < half; ++i) {
    EXPECT_EQ(skin.side[i], 0);
    EXPECT_EQ(skin.side[half + i], 1);
    const Eigen::Vector3f flip(-1.0F, 1.0F, 1.0F);
    EXPECT_LT((skin.position[i].cwiseProduct(flip) - skin.position[half + i]).norm(), 1e-6F);
    EXPECT_LT((skin.normal[i].cwiseProduct(flip) - skin.normal[half + i]).norm(), 1e-5F);
    EXPECT_EQ(skin.region[i], skin.region[half + i]);
    EXPECT_EQ(skin.area[i], skin.area[half + i]);
  }
}

TEST(KinematicHand, PadDistanceIsSmallAtPadsAndGrowsTowardTheWrist) {
  KinematicHands hands(coarse);
  const TrackedHand hand = flatHand(Side::right);
  const Skin skin = hands.update({hand}, nanoseconds(0));
  std::map<int, std::pair<double, double>> by_region;  // smallest, mean
  std::map<int, int> count;
  for (std::size_t i = 0; i < skin.size(); ++i) {
    auto& [smallest, mean] = by_region.try_emplace(skin.region[i], 1.0, 0.0).first->second;
    smallest = std::min<double>(smallest, skin.pad_distance[i]);
    mean += skin.pad_distance[i];
    ++count[skin.region[i]];
  }
  for (auto& [region, distances] : by_region) distances.second /= count[region];
  for (const FingerJoints& finger : fingers) {
    EXPECT_LT(by_region[finger[finger.count - 2]].first, coarse) << finger.first;
    for (int i = 0; i + 2 < finger.count; ++i)
      EXPECT_GT(by_region[finger[i]].second, by_region[finger[i + 1]].second) << finger[i];
  }
  // The shortest way along the skin is no shorter than the straight one, here from the index pad in the rest
  // pose.
  EXPECT_GT(by_region[wrist].first, 0.06);
}

TEST(KinematicHand, RefusesAHandThatIsNotSaneAndKeepsItsState) {
  KinematicHands hands(coarse);
  TrackedHand hand = flatHand(Side::right);
  hands.update({hand}, milliseconds(0));
  TrackedHand bad = hand;
  bad.joints[index_tip].position.x() = std::nan("");
  EXPECT_THROW(hands.update({bad}, milliseconds(10)), std::invalid_argument);
  transform(hand, Eigen::Isometry3d(Eigen::Translation3d(0.01, 0.0, 0.0)));
  EXPECT_NEAR(hands.update({hand}, milliseconds(10)).velocity[0].x(), 1.0F, 1e-3F);
}

TEST(KinematicHand, TwoHandsOfOneSideGiveTheMoreConfident) {
  KinematicHands hands(coarse);
  TrackedHand near = flatHand(Side::right);
  TrackedHand far = near;
  transform(far, Eigen::Isometry3d(Eigen::Translation3d(1.0, 0.0, 0.0)));
  near.confidence = 0.3;
  const Skin skin = hands.update({near, far}, nanoseconds(0));
  for (const Eigen::Vector3f& x : skin.position) EXPECT_GT(x.x(), 0.5F);
}

}  // namespace
}  // namespace tactile_clay::hand::kinematic_hand_test
