#include "hand/hand_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "bent_hand.h"
#include "hand/anatomy.h"
#include "hand/hand_pose.h"
#include "support/hand_recording.h"

namespace tactile_clay::hand::hand_check_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Expects that nothing is wrong, and that nothing is changed.
void expectTaken(const TrackedHand& hand, const std::string& what) {
  TrackedHand judged = hand;
  const HandFaults faults = judge(judged);
  EXPECT_TRUE(faults.usable) << what;
  EXPECT_EQ(faults.lines, std::vector<std::string>()) << what;
  EXPECT_TRUE(judged.missing.none()) << what;
  for (int joint = 0; joint < joint_count; ++joint)
    EXPECT_TRUE(sameBits(judged.joints[joint], hand.joints[joint])) << what << ", joint " << joint;
}

TEST(HandCheck, TakesHandsOfAllSizesInAllPoses) {
  std::mt19937 random(31);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  constexpr double beyond = 15.0 * M_PI / 180.0;  // bent back and crossed farther than the tables' ranges
  for (int i = 0; i < 2000; ++i) {
    HandPose pose;
    pose.side = i % 2 == 0 ? Side::left : Side::right;
    pose.scale = 0.7 + 0.6 * share(random);
    pose.wrist =
        Eigen::Translation3d(share(random), share(random), share(random)) * Eigen::Quaterniond::UnitRandom();
    for (int f = 0; f < finger_count; ++f) {
      const auto within = [&](const Eigen::Vector2d& limit) {
        return limit[0] - beyond + share(random) * (limit[1] - limit[0] + 2.0 * beyond);
      };
      for (int k = 0; k < 3; ++k) pose.fingers[f].flexion[k] = within(finger_limits[f].flexion[k]);
      pose.fingers[f].abduction = within(finger_limits[f].abduction);
    }
    expectTaken(forwardKinematics(pose), "hand " + std::to_string(i));
  }
}

TEST(HandCheck, TakesEveryHandOfTheRecordings) {
  int found = 0;
  for (const char* name : hand_recordings) {
    const auto frames = recordedFrames(name);
    if (!frames) continue;
    ++found;
    for (const TrackedFrame& frame : *frames)
      for (const TrackedHand& hand : frame.hands) {
        expectTaken(hand, name);
        if (HasFailure()) return;
      }
  }
  if (found == 0) GTEST_SKIP() << "no recordings";
}

// The models of the hand need only numbers that can be posed; whether it is a plausible hand is judged
// separately.
TEST(HandCheck, FaultsOfNumbersAreThoseThatNoModelCanPose) {
  const TrackedHand hand = bentHand();
  EXPECT_EQ(faultOfNumbers(hand), "");
  TrackedHand tiny = hand;
  for (JointPose& joint : tiny.joints) joint.position *= 1e-3;
  EXPECT_EQ(faultOfNumbers(tiny), "");
  EXPECT_NE(faultOf(tiny), "");
  const auto spoilt = [&](const std::function<void(TrackedHand&)>& spoil) {
    TrackedHand bad = hand;
    spoil(bad);
    return faultOfNumbers(bad);
  };
  EXPECT_TRUE(
      contains(spoilt([](auto& h) { h.joints[index_tip].position.z() = nan; }), "joint index_tip: position"));
  EXPECT_TRUE(
      contains(spoilt([](auto& h) { h.joints[wrist].orientation.coeffs().setZero(); }), "orientation"));
  for (const double radius : {nan, infinity, -0.01})
    EXPECT_TRUE(
        contains(spoilt([&](auto& h) { h.joints[thumb_tip].radius = radius; }), "joint thumb_tip: radius"));
  EXPECT_TRUE(contains(spoilt([](auto& h) { h.confidence = nan; }), "hand 7: confidence"));
  EXPECT_TRUE(contains(spoilt([](auto& h) { h.side = static_cast<Side>(7); }), "side 7"));
}

TEST(HandCheck, RadiiThatNoHandHasAreThoseOfTheTable) {
  const TrackedHand good = bentHand(Side::left, 0.9);
  for (const double wrong : {0.0, -0.01, nan, infinity, 0.09, 8.0}) {
    for (const bool all : {false, true}) {
      TrackedHand hand = good;
      for (int joint = 0; joint < joint_count; ++joint)
        if (all || joint == ring_tip) hand.joints[joint].radius = wrong;
      const HandFaults faults = judge(hand);
      ASSERT_TRUE(faults.usable) << wrong;
      ASSERT_EQ(faults.lines.size(), 1U) << wrong;
      EXPECT_TRUE(contains(faults.lines[0], all ? "its radii are" : "joint ring_tip: radius"))
          << faults.lines[0];
      EXPECT_TRUE(hand.missing.none()) << wrong;
      for (int joint = 0; joint < joint_count; ++joint)
        EXPECT_NEAR(hand.joints[joint].radius, 0.9 * joint_anatomy[joint].radius, 1e-12) << wrong;
    }
  }
}

// Radii are judged as one set too: halves, doubles and one radius for all joints change the force.
TEST(HandCheck, RadiiThatAreWrongAsOneSetAreAllReplaced) {
  const auto times = [](double factor) {
    return [factor](TrackedHand& hand) {
      for (JointPose& joint : hand.joints) joint.radius *= factor;
    };
  };
  const auto two_millimetres = [](TrackedHand& hand) {
    for (JointPose& joint : hand.joints) joint.radius = 2e-3;
  };
  for (const double scale : {0.7, 1.05, 1.3}) {
    const TrackedHand good = bentHand(Side::left, scale);
    for (const std::function<void(TrackedHand&)>& spoil :
         {std::function<void(TrackedHand&)>(times(0.25)), std::function<void(TrackedHand&)>(two_millimetres),
          std::function<void(TrackedHand&)>(times(2.0)), std::function<void(TrackedHand&)>(times(3.0))}) {
      TrackedHand hand = good;
      hand.missing.set(little_tip);  // it has no radius to replace
      spoil(hand);
      const HandFaults faults = judge(hand);
      ASSERT_TRUE(faults.usable);
      EXPECT_EQ(faults.fingers, 0);
      ASSERT_EQ(faults.lines.size(), 1U);
      EXPECT_TRUE(contains(faults.lines[0], "left hand 7: its radii are ")) << faults.lines[0];
      EXPECT_TRUE(contains(faults.lines[0], "expected 0.35 to 1.8 times")) << faults.lines[0];
      for (int joint = 0; joint < joint_count; ++joint)
        EXPECT_NEAR(hand.joints[joint].radius, hand.missing[joint] ? 0.0 : good.joints[joint].radius, 1e-12);
      EXPECT_EQ(faultOf(hand), "");
    }
    // Trackers have other radii, and a hand that fades out has half of them.
    for (const double factor : {0.4, 0.5, 1.19, 1.6}) {
      TrackedHand hand = good;
      times(factor)(hand);
      expectTaken(hand, "radii");
    }
  }
}

// The palm's radius is the distance to the skin; other trackers define it in other ways.
TEST(HandCheck, AnotherDefinitionOfOneRadiusIsTaken) {
  TrackedHand hand = bentHand(Side::right);
  hand.joints[palm].radius = 0.025;
  expectTaken(hand, "palm");
}

}  // namespace
}  // namespace tactile_clay::hand::hand_check_test
