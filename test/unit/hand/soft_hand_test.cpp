#include "hand/soft_hand.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "hand/anatomy.h"
#include "hand/hand_pose.h"
#include "hand/skin_template.h"
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
  for (const Side side : {Side::left, Side::right}) {
    const TrackedHand rest = restHand(side, 1.03);
    SoftHands soft(coarse_spacing, coarse());
    KinematicHands kinematic(coarse_spacing);
    soft.update({rest}, stampOf(0));
    const Skin& a = soft.update({rest}, stampOf(1));
    const Skin& b = kinematic.update({rest}, stampOf(1));
    ASSERT_EQ(a.size(), b.size());
    EXPECT_EQ(a.region, b.region);
    EXPECT_EQ(a.side, b.side);
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_LT((a.position[i] - b.position[i]).norm(), 1e-5F);
      EXPECT_GT(a.normal[i].dot(b.normal[i]), 0.9999F);
      EXPECT_NEAR(a.area[i] / b.area[i], 1.0F, 1e-2F);
      EXPECT_NEAR(a.pad_distance[i], b.pad_distance[i], 1e-5F);
      EXPECT_LT(a.velocity[i].norm(), 1e-3F);
    }
  }
}

TEST(SoftHand, LossJumpAndStandingClock) {
  SoftHands hands(coarse_spacing, coarse());
  TrackedHand hand = palmDown(0.0);
  settled(hands, hand, 0, 3);
  EXPECT_EQ(fastest(hands.update({hand}, stampOf(2))), 0.0);
  for (JointPose& joint : hand.joints) joint.position.x() += 0.6;
  EXPECT_EQ(fastest(hands.update({hand}, stampOf(3))), 0.0);
  EXPECT_EQ(hands.update({}, stampOf(4)).size(), 0U);
  EXPECT_EQ(hands.hand(Side::right), nullptr);
  EXPECT_EQ(fastest(hands.update({hand}, stampOf(5))), 0.0);
  TrackedHand bad = hand;
  bad.joints[index_tip].position.x() = std::nan("");
  EXPECT_THROW(hands.update({bad}, stampOf(6)), std::invalid_argument);
  EXPECT_THROW(SoftHands(0.1), std::invalid_argument);
  SoftHandParameters rubber;
  rubber.poisson = 0.5;
  EXPECT_THROW(SoftHands(spacing, rubber), std::invalid_argument);
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
