#include "hand/jump_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "bent_hand.h"
#include "hand/repeated_hands.h"

namespace tactile_clay::hand::jump_check_test {
namespace {

using namespace std::chrono_literals;
using Eigen::Vector3d;

TrackedHand at(const Vector3d& position, Side side = Side::right) {
  TrackedHand hand = bentHand(side);
  for (JointPose& joint : hand.joints) joint.position += position;
  return hand;
}

TEST(JumpCheck, AHandIsNotInTwoPlacesInTurn) {
  JumpCheck check;
  std::vector<std::size_t> left;
  for (int i = 0; i < 12; ++i) {
    // It jumps to and fro; its other hand stays. From the ninth sample on it is somewhere else.
    std::vector<TrackedHand> hands = {at(i < 8 && i % 2 == 1 ? Vector3d(0.4, 0.0, 0.0) : Vector3d::Zero()),
                                      at({0.0, 0.3, 0.0}, Side::left)};
    const LeftOut out = check.leaveOutJumps(hands, i * 10ms);
    left.push_back(out.hands);
    ASSERT_EQ(hands.size(), 2 - out.hands);
    EXPECT_EQ(hands.back().side, Side::left);
    for (const std::string& line : out.lines)
      EXPECT_TRUE(contains(line, "right hand 7 left out: joint palm: it jumped"));
  }
  EXPECT_EQ(left, std::vector<std::size_t>({0, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0}));
}

TEST(JumpCheck, AThrowIsNoJump) {
  JumpCheck check;
  for (int i = 0; i < 20; ++i) {  // 12 m/s, and a slow tracker's steps
    std::vector<TrackedHand> hands = {at({0.12 * i, 0.0, 0.0})};
    EXPECT_EQ(check.leaveOutJumps(hands, i * 10ms).hands, 0U);
  }
  JumpCheck slow;
  for (int i = 0; i < 20; ++i) {
    std::vector<TrackedHand> hands = {at({0.3 * i, 0.0, 0.0})};
    EXPECT_EQ(slow.leaveOutJumps(hands, i * 66ms).hands, 0U);
  }
}

TEST(RepeatedHands, WhatHasTheSameBitsWasNotSeenAgain) {
  RepeatedHands check(0ns);
  TrackedHand still = at(Vector3d::Zero());
  for (int i = 0; i < 30; ++i) {
    TrackedHand moving = at({0.0, 0.3 + 1e-9 * i, 0.0}, Side::left);
    still.id = 100 + i;  // what the tracker says beside the joints is no sign of life
    still.confidence = 0.01 * i;
    std::vector<TrackedHand> hands = {still, moving};
    const LeftOut out = check.leaveOutRepeats(hands, i * 10ms);
    EXPECT_EQ(out.hands, i == 0 ? 0U : 1U) << i;
    EXPECT_EQ(hands.size(), i == 0 ? 2U : 1U) << i;
    EXPECT_EQ(hands.back().side, Side::left);
    EXPECT_EQ(out.lines.size(), i < 5 ? 0U : 1U) << i;  // a driver may send a sample twice
    if (i != 20) continue;
    EXPECT_TRUE(contains(out.lines.at(0), "is frozen, all of its joints are the same for 200 ms"))
        << out.lines[0];
  }
  std::vector<TrackedHand> hands = {at({1e-12, 0.0, 0.0})};
  EXPECT_EQ(check.leaveOutRepeats(hands, 300ms).hands, 0U);
}

TEST(RepeatedHands, AreWaitedForWhereNobodyBridgesThem) {
  RepeatedHands check(60ms);
  for (int i = 0; i < 60; ++i) {  // each sample twice, then one for ever
    std::vector<TrackedHand> hands = {at({0.001 * std::min(i / 2, 20), 0.0, 0.0})};
    const LeftOut out = check.leaveOutRepeats(hands, i * 10ms);
    EXPECT_EQ(out.hands, i < 46 ? 0U : 1U) << i;
  }
}

// A tracker with several buffers may send the samples in them in turn, or a rotation with either sign.
TEST(RepeatedHands, SamplesThatComeInTurnAreRepeatedToo) {
  for (const int buffers : {2, 3, 8}) {
    RepeatedHands check(0ns);
    for (int i = 0; i < 40; ++i) {
      TrackedHand hand = at({0.001 * (i % buffers), 0.0, 0.0});
      if (i % 5 == 0)
        for (JointPose& joint : hand.joints) joint.orientation.coeffs() *= -1.0;
      std::vector<TrackedHand> hands = {hand};
      EXPECT_EQ(check.leaveOutRepeats(hands, i * 10ms).hands, i < buffers ? 0U : 1U) << buffers << ", " << i;
    }
  }
}

}  // namespace
}  // namespace tactile_clay::hand::jump_check_test
