// A soft hand pressed on floors from soft to stiff: where it stops, how quiet the force is, how it leaves.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "hand/hand_shape.h"
#include "hand/soft_hands.h"
#include "support/pressed_hand.h"
#include "watched_hand.h"

namespace tactile_clay::hand::soft_hand_floor_test {
namespace {

// The tracked finger goes 10 mm into a floor of 1 kN/m per sample: the virtual finger stays on it.
TEST(SoftHand, FingerStopsAtAStiffFloor) {
  Press press(1000.0, true);
  press.approach(-0.01);
  for (int k = 0; k < 60; ++k) press.frame(-0.01);
  EXPECT_LT(press.depth, 2e-3);
  EXPECT_GT(press.force, 1.0);
  EXPECT_LT(press.force, 30.0);
  // The springs of the bones carry the force of the floor.
  EXPECT_NEAR(press.soft().force().y() / press.force, 1.0, 0.02);
  const auto target = bodyPoses(press.tracked, restHand(Side::right, 1.0));
  const Couplings couplings;
  double springs = 0.0;
  for (int b = 0; b < body_count; ++b)
    springs += (b == palm_body ? couplings.palm : couplings.finger) *
               (press.soft().bodies()[b].position.y() - target[b].position.y());
  EXPECT_NEAR(springs / press.force, 1.0, 0.05);
  constexpr int index_tip_bone = 6;
  EXPECT_GT(press.soft().bodies()[index_tip_bone].position.y() - target[index_tip_bone].position.y(), 1e-3);
}

// The haptic loop at rest, over floors from soft to stiff; also 20 mm deep, where a finger gets up to 8 N and
// its pad is flat.
TEST(SoftHand, LoopIsQuietOnSoftAndStiffFloors) {
  for (const bool pointing : {true, false})
    for (const auto& [stiffness, depth] :
         {std::pair{30.0, 0.01}, {300.0, 0.01}, {1000.0, 0.01}, {1000.0, 0.015}, {1000.0, 0.02}}) {
      Press press(stiffness, pointing);
      press.approach(-depth);
      for (int k = 0; k < 90; ++k) press.frame(-depth);
      std::vector<double> force;
      for (int k = 0; k < 120; ++k) {
        press.frame(-depth);
        force.push_back(press.force);
        ASSERT_GT(press.force, 0.1);
      }
      EXPECT_LT(buzz(force), 0.05) << stiffness << ' ' << depth << (pointing ? " finger" : " palm");
    }
}

// A pad flattens: contact area grows with force, for small loads between Hertz's F^(2/3) and a flat punch's
// F^0.
TEST(SoftHand, ContactAreaGrowsWithForce) {
  std::vector<double> area, force;
  for (const double press_depth : {0.001, 0.003, 0.006}) {
    Press press(300.0, false);
    press.approach(-press_depth);
    for (int k = 0; k < 60; ++k) press.frame(-press_depth);
    area.push_back(press.area);
    force.push_back(press.force);
  }
  for (int k = 0; k + 1 < 3; ++k) {
    EXPECT_GT(force[k + 1], force[k]);
    EXPECT_GT(area[k + 1], area[k]);
    const double exponent = std::log(area[k + 1] / area[k]) / std::log(force[k + 1] / force[k]);
    EXPECT_GT(exponent, 0.1);
    EXPECT_LT(exponent, 1.0);
  }
}

TEST(SoftHand, LeavesWithoutSticking) {
  for (const double friction : {0.0, 0.6}) {
    Press press(1000.0, true, friction);
    press.approach(-0.008);
    for (int k = 0; k < 60; ++k) press.frame(-0.008);
    ASSERT_GT(press.force, 0.5);
    for (int k = 1; k <= 12; ++k) press.frame(-0.008 + 0.005 * k);
    EXPECT_EQ(press.force, 0.0);
    EXPECT_EQ(press.soft().force().norm(), 0.0);
    for (int k = 0; k < 30; ++k) press.frame(0.052);
    SoftHands fresh(spacing);
    settled(fresh, press.tracked, 0, 121);
    const Skin free = fresh.update({press.tracked}, stampOf(121));
    double mean = 0.0;
    for (std::size_t i = 0; i < free.size(); ++i) mean += (free.position[i] - press.skin.position[i]).norm();
    EXPECT_LT(mean / static_cast<double>(free.size()), 5e-4);
  }
}

// With up to 2.6 N on a finger and 7 N on a flat hand, which come to rest 10 mm deep, flesh is inside out in
// no frame. At 15 mm, with 5 and 16 N, it is for at most three frames.
TEST(SoftHand, FleshPressedOnAFloorIsNotInsideOut) {
  for (const bool pointing : {true, false})
    for (const double stiffness : {300.0, 1000.0})
      for (const double depth : {0.01, 0.015}) {
        Press press(stiffness, pointing, 0.6);
        InsideOut inside_out;
        for (int k = 0; k < 120; ++k) {
          press.frame(std::max(-depth, 0.01 - 0.03 * k * frame));
          inside_out.see(press.soft());
        }
        ASSERT_GT(press.force, 1.0);
        const char* part = pointing ? "finger" : "palm";
        EXPECT_LE(inside_out.longest, depth > 0.01 ? 3 : 0) << part << ' ' << stiffness << ' ' << depth;
      }
}

}  // namespace
}  // namespace tactile_clay::hand::soft_hand_floor_test
