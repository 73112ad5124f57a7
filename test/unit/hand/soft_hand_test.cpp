#include "hand/soft_hand.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "hand/anatomy.h"
#include "hand/hand_pose.h"
#include "hand/skin_template.h"
#include "support/hand_recording.h"
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

HandPose bent(const FingerAngles& thumb, double flexion) {
  HandPose pose;
  for (FingerAngles& finger : pose.fingers) finger.flexion.fill(flexion);
  pose.fingers[0] = thumb;
  return pose;
}

double farthest(const TrackedHand& a, const TrackedHand& b) {
  double most = 0.0;
  for (int j = 0; j < joint_count; ++j)
    most = std::max(most, (a.joints[j].position - b.joints[j].position).norm());
  return most;
}

// Whatever the sides: the palm stays, bones keep their lengths, a second time changes nothing.
TEST(WithinReach, TurnsBackWhatIsOutsideAndOnlyThat) {
  for (const Side side : {Side::left, Side::right})
    for (HandPose pose :
         {bent({}, 0.0), bent({{0.6, 0.5, 0.8}, 0.35}, 1.5), bent({{0.6, 0.5, 0.8}, -0.6}, 0.0),
          bent({}, 2.5), bent({{-1.0, -2.0, -2.0}, 2.0}, -1.5)}) {
      const bool possible = pose.fingers[0].abduction > -0.5 && std::abs(pose.fingers[1].flexion[0]) < 1.6 &&
                            pose.fingers[1].flexion[0] > -0.1;
      pose.side = side;
      pose.scale = 0.9;
      pose.wrist =
          Eigen::Translation3d(0.1, 0.2, 0.3) * Eigen::AngleAxisd(1.0, Vector3d(1, 2, 3).normalized());
      const TrackedHand tracked = forwardKinematics(pose), hand = withinReach(tracked);
      if (possible)
        EXPECT_EQ(farthest(hand, tracked), 0.0);
      else
        EXPECT_GT(farthest(hand, tracked), 0.01);
      EXPECT_LT(farthest(withinReach(hand), hand), 1e-9);
      for (int j = 0; j < joint_count; ++j) {
        const int parent = joint_anatomy[j].parent;
        const auto length = [&](const TrackedHand& h) {
          return (h.joints[j].position - h.joints[parent].position).norm();
        };
        EXPECT_NEAR(length(hand), length(tracked), 1e-9) << j;
      }
    }
}

// What is beyond the joint goes with it.
TEST(WithinReach, LeadsRootsOfFingersToTheirPlaceAndGivesBonesTheirLength) {
  const HandPose pose = bent({}, 0.5);
  const TrackedHand possible = forwardKinematics(pose);
  struct Root {
    Joint joint, tip;
    double reach;  // m
  };
  for (const Root& root : {Root{index_proximal, index_tip, 0.006}, {thumb_metacarpal, thumb_tip, 0.012}}) {
    TrackedHand off = possible;
    const Vector3d by(0.01, 0.03, 0.0);
    for (int j = root.joint; j <= root.tip; ++j) off.joints[j].position += by;
    const TrackedHand hand = withinReach(off);
    const BodyPose palm_pose = bodyPoses(off, possible)[palm_body];
    const Vector3d in_palm = possible.joints[root.joint].position - bodyCentres(possible)[palm_body];
    const Vector3d place = palm_pose.position + palm_pose.rotation * in_palm;
    EXPECT_NEAR((hand.joints[root.joint].position - place).norm(), root.reach, 1e-6);
    const Vector3d shift = hand.joints[root.joint].position - off.joints[root.joint].position;
    for (int j = root.joint; j <= root.tip; ++j)
      EXPECT_LT((hand.joints[j].position - off.joints[j].position - shift).norm(), 1e-9) << j;
  }
  for (const double stretch : {0.2, 1.0, 3.0}) {
    TrackedHand odd = possible;
    const Vector3d bone =
        possible.joints[ring_intermediate].position - possible.joints[ring_proximal].position;
    for (const Joint joint : {ring_intermediate, ring_distal, ring_tip})
      odd.joints[joint].position += (stretch - 1.0) * bone;
    const TrackedHand hand = withinReach(odd);
    const Vector3d shift = (std::clamp(stretch, 0.8, 1.25) - 1.0) * bone;
    for (int j = 0; j < joint_count; ++j) {
      const bool beyond = j >= ring_intermediate && j <= ring_tip;
      const Vector3d expected = possible.joints[j].position + (beyond ? shift : Vector3d::Zero());
      EXPECT_LT((hand.joints[j].position - expected).norm(), 1e-9) << stretch << ' ' << j;
    }
  }
}

TEST(WithinReach, RecordedHandsAre) {
  int hands = 0, changed = 0;
  for (const char* name : {"both_hands_low_confidence", "finger_tap", "grab", "left_or_right",
                           "pinch_and_move", "three_claps"}) {
    const auto frames = recordedFrames(name);
    if (!frames) GTEST_SKIP() << handRecording(name) << " is not here";
    for (const TrackedFrame& frame : *frames)
      for (const TrackedHand& hand : frame.hands) {
        const double most = farthest(withinReach(hand), hand);
        EXPECT_LT(most, 5e-4) << name;
        ++hands;
        changed += most > 0.0;
      }
  }
  std::printf("  %d of %d recorded hands turned back\n", changed, hands);
  EXPECT_LT(changed, hands / 100);
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
