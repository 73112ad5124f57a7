#include "hand/soft_hands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "hand/anatomy.h"
#include "hand/hand_pose.h"
#include "hand/hand_shape.h"
#include "support/pressed_hand.h"

namespace tactile_clay::hand::soft_hand_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using std::chrono::nanoseconds;

// The coarsest flesh and skin that are allowed: test/stability uses those that are shipped.
SoftHandParameters coarse() {
  SoftHandParameters parameters;
  parameters.finger_cell = 10e-3;
  parameters.palm_cell = 15e-3;
  return parameters;
}
constexpr double coarse_spacing = 10e-3;  // m

TEST(SoftHand, AtRestItIsTheKinematicHand) {
  expectKinematicAtRest(coarse_spacing, coarse());
}

// Whatever holds the virtual hand back, the tracked one feels it where it is.
void expectFeltOnTracked(const Skin& skin, KinematicHands& tracked, const std::vector<TrackedHand>& hands,
                         int k) {
  const Skin expected = tracked.update(hands, stampOf(k));
  ASSERT_EQ(skin.size(), expected.size());
  EXPECT_EQ(skin.tracked_position, expected.position);
  EXPECT_EQ(skin.tracked_normal, expected.normal);
  EXPECT_EQ(skin.region, expected.region);
  EXPECT_EQ(skin.side, expected.side);
  ASSERT_EQ(skin.tracked_area.size(), skin.size());
  for (std::size_t i = 0; i < skin.size(); ++i)
    EXPECT_TRUE(skin.tracked_area[i] == expected.area[i] || skin.tracked_area[i] == 0.0F) << i;
}

TEST(SoftHand, TellsWhereTheTrackedHandFeelsIt) {
  Press press(1000.0, true, 0.0, coarse_spacing, coarse());
  KinematicHands tracked(coarse_spacing, SkinKind::soft);
  double held = 0.0;
  for (int k = 0; k < 60; ++k) {
    press.frame(0.01 - 0.5e-3 * k);
    expectFeltOnTracked(press.skin, tracked, {press.tracked}, k);
    for (std::size_t i = 0; i < press.skin.size(); ++i)
      held =
          std::max(held, static_cast<double>((press.skin.position[i] - press.skin.tracked_position[i]).y()));
  }
  EXPECT_GT(held, 5e-3) << "m, that the floor holds the virtual finger above the tracked one";
}

TEST(SoftHand, TellsItOfBothHandsAndOfOneThatComesBack) {
  SoftHands soft(coarse_spacing, coarse());
  KinematicHands tracked(coarse_spacing, SkinKind::soft);
  TrackedHand right = palmDown(0.0), left = restHand(Side::left, 1.0);
  for (JointPose& joint : left.joints) joint.position.x() -= 0.3;
  int k = 0;
  for (const std::vector<TrackedHand>& hands :
       {std::vector<TrackedHand>{right}, {right, left}, {left}, {}, {right, left}}) {
    expectFeltOnTracked(soft.update(hands, stampOf(k)), tracked, hands, k);
    ++k;
  }
  for (JointPose& joint : right.joints) joint.position.z() += 0.8;
  expectFeltOnTracked(soft.update({right, left}, stampOf(k)), tracked, {right, left}, k);
}

// Finger pads in a fist are on the palm's skin, and cannot be reached from outside.
TEST(SoftHand, WhatTheTrackedHandCoversHasNoAreaThere) {
  SoftHands soft(coarse_spacing, coarse());
  const TrackedHand fist = palmDown(0.0, false, 1.5);
  const Skin skin = soft.update({fist}, stampOf(0));
  int covered = 0;
  for (std::size_t i = 0; i < skin.size(); ++i) {
    const double distance = handDistance(fist, skin.tracked_position[i].cast<double>());
    if (skin.tracked_area[i] > 0.0F) {
      EXPECT_GT(distance, -3e-3) << i;
    } else {
      EXPECT_LT(distance, -1e-3) << i;
    }
    covered += skin.tracked_area[i] == 0.0F ? 1 : 0;
  }
  EXPECT_GT(covered, 10);
  const Skin flat = soft.update({restHand(Side::right, 1.0)}, stampOf(1));
  EXPECT_EQ(std::count(flat.tracked_area.begin(), flat.tracked_area.end(), 0.0F), 0);
}

// Loads end when the clay sends nothing, also if the clock is set back meanwhile.
TEST(SoftHand, ForcesOfATimeToComeAreForgotten) {
  SoftHands hands(coarse_spacing, coarse());
  const TrackedHand hand = palmDown(0.0);
  int k = settled(hands, hand, 1000, 5);
  EXPECT_EQ(hands.react(stampOf(k - 1), {{0, {0.0F, 2.0F, 0.0F}}}), 0U);
  hands.update({hand}, stampOf(k));
  EXPECT_GT(hands.hand(Side::right)->force().norm(), 0.1);
  settled(hands, hand, 0, 4);
  EXPECT_EQ(hands.hand(Side::right)->force().norm(), 0.0);
}

TEST(SoftHand, LossJumpFlipAndStandingClock) {
  SoftHands hands(coarse_spacing, coarse());
  TrackedHand hand = palmDown(0.0);
  settled(hands, hand, 0, 3);
  EXPECT_EQ(fastest(hands.update({hand}, stampOf(2))), 0.0);
  for (JointPose& joint : hand.joints) joint.position.x() += 0.6;
  EXPECT_EQ(fastest(hands.update({hand}, stampOf(3))), 0.0);
  const auto turned = [&](double angle) {
    TrackedHand other = hand;
    const Eigen::AngleAxisd turn(angle, Vector3d::UnitZ());
    for (JointPose& joint : other.joints) {
      joint.position = hand.joints[palm].position + turn * (joint.position - hand.joints[palm].position);
      joint.orientation = turn * joint.orientation;
    }
    return other;
  };
  const std::vector<Vector3f> flipped = hands.update({turned(M_PI)}, stampOf(4)).position;
  SoftHands anew(coarse_spacing, coarse());
  EXPECT_EQ(anew.update({turned(M_PI)}, stampOf(4)).position, flipped);
  EXPECT_GT(fastest(hands.update({turned(M_PI - 1.0)}, stampOf(5))), 1.0);
  EXPECT_EQ(fastest(hands.update({hand}, stampOf(6))), 0.0);
  EXPECT_EQ(hands.update({}, stampOf(7)).size(), 0U);
  EXPECT_EQ(hands.hand(Side::right), nullptr);
  EXPECT_EQ(fastest(hands.update({hand}, stampOf(8))), 0.0);
  TrackedHand bad = hand;
  bad.joints[index_tip].position.x() = std::nan("");
  EXPECT_THROW(hands.update({bad}, stampOf(9)), std::invalid_argument);
  EXPECT_THROW(SoftHands(0.1), std::invalid_argument);
  SoftHandParameters rubber;
  rubber.poisson = 0.5;
  EXPECT_THROW(SoftHands(spacing, rubber), std::invalid_argument);
}

// Otherwise bones alone would decide whether a tetrahedron is inverted.
TEST(SoftHandTemplate, EveryTetrahedronHasACornerOfFlesh) {
  for (const Side side : {Side::left, Side::right}) {
    const SoftHandParameters shipped;
    const SoftHandTemplate hand = makeSoftHandTemplate(side, shipped.finger_cell, shipped.palm_cell);
    for (const auto& t : hand.mesh.tetrahedra)
      EXPECT_TRUE(std::any_of(t.begin(), t.end(), [&](int n) { return !hand.bindings[n].rigid; }));
  }
}

// A few frames of each kind of trouble, so that the sanitizers see all of the code: test/stability has the
// long runs.
TEST(SoftHand, FewFramesOfLoadsGarbageAndImpossiblePosesStayFinite) {
  Press press(1000.0, true, 0.6, coarse_spacing, coarse());
  for (const double height : {0.0, -0.004, -0.008}) press.frame(height);
  EXPECT_GT(press.force, 0.0);
  EXPECT_TRUE(allFinite(press.skin));
  const float nan = std::nanf("");
  EXPECT_EQ(press.hands.react(stampOf(2), {{0, {nan, 0, 0}}, {1u << 30, {0, 1, 0}}, {1, {1e30F, 0, 0}}}), 2U);
  EXPECT_TRUE(allFinite(press.hands.update({palmDown(0.0, false, 2.5)}, stampOf(3))));
}

}  // namespace
}  // namespace tactile_clay::hand::soft_hand_test
