#include "hand/soft_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "hand/anatomy.h"
#include "hand/hand_pose.h"
#include "support/pressed_hand.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using std::chrono::nanoseconds;

// Flesh and skin as coarse as they may be: test/stability has those that are shipped.
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

// Else bones alone would decide whether it is right side out.
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
}  // namespace tactile_clay::hand
