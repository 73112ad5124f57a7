#include <gtest/gtest.h>

#include <cmath>

#include "hand/anatomy.h"
#include "hand/hand_pose.h"
#include "hand/hand_sides.h"

namespace tactile_clay::hand::pose_test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

HandPose bentPose(Side side) {
  HandPose pose;
  pose.side = side;
  pose.scale = 1.07;
  pose.wrist =
      Eigen::Translation3d(0.1, -0.2, 0.3) * Eigen::AngleAxisd(0.7, Vector3d(1.0, -2.0, 0.5).normalized());
  for (int finger = 0; finger < finger_count; ++finger) {
    pose.fingers[finger].flexion = {0.2 + 0.1 * finger, 0.3, 0.25};
    pose.fingers[finger].abduction = 0.05 * (2 - finger);
  }
  return pose;
}

TEST(HandPose, BonesHaveTheTablesLengthsTimesTheScale) {
  for (const Side side : {Side::left, Side::right}) {
    const TrackedHand hand = forwardKinematics(bentPose(side));
    int bone_count = 0;
    for (int joint = 0; joint < joint_count; ++joint) {
      EXPECT_DOUBLE_EQ(hand.joints[joint].radius, 1.07 * joint_anatomy[joint].radius);
      if (joint_anatomy[joint].bone_length == 0.0) continue;
      ++bone_count;
      const JointPose& parent = hand.joints[joint_anatomy[joint].parent];
      EXPECT_NEAR((hand.joints[joint].position - parent.position).norm(),
                  1.07 * joint_anatomy[joint].bone_length, 1e-12)
          << joint_anatomy[joint].name;
    }
    EXPECT_EQ(bone_count, 19);
    EXPECT_NEAR(personScale(hand), 1.07, 1e-12);
  }
}

TEST(HandPose, FramesAreRightHandedWithMinusZAlongTheBone) {
  for (const Side side : {Side::left, Side::right}) {
    const TrackedHand hand = forwardKinematics(bentPose(side));
    for (int joint = 0; joint < joint_count; ++joint) {
      const Eigen::Matrix3d frame = hand.joints[joint].orientation.toRotationMatrix();
      EXPECT_NEAR(frame.determinant(), 1.0, 1e-12);
      EXPECT_LT((frame * frame.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
      if (joint_anatomy[joint].bone_length == 0.0) continue;
      const JointPose& parent = hand.joints[joint_anatomy[joint].parent];
      const Vector3d bone = (hand.joints[joint].position - parent.position).normalized();
      EXPECT_LT((parent.orientation * -Vector3d::UnitZ() - bone).norm(), 1e-9) << joint_anatomy[joint].name;
    }
    EXPECT_LT((hand.joints[wrist].position - Vector3d(0.1, -0.2, 0.3)).norm(), 1e-12);
  }
}

TEST(HandPose, FlexionGoesToThePalmAndTheThumbIsOnItsSide) {
  for (const Side side : {Side::left, Side::right}) {
    HandPose pose;
    pose.side = side;
    const TrackedHand flat = forwardKinematics(pose);
    for (int finger = 1; finger < finger_count; ++finger) pose.fingers[finger].flexion = {0.5, 0.5, 0.5};
    const TrackedHand bent = forwardKinematics(pose);
    for (int finger = 1; finger < finger_count; ++finger)
      EXPECT_LT(bent.joints[fingers[finger].tip()].position.y(),
                flat.joints[fingers[finger].tip()].position.y() - 0.02);
    const double thumb_side = side == Side::right ? -1.0 : 1.0;
    EXPECT_GT(thumb_side * flat.joints[thumb_tip].position.x(), 0.02);
    EXPECT_LT(thumb_side * flat.joints[little_tip].position.x(), -0.01);
    pose.fingers[1].abduction = 0.3;
    EXPECT_GT(thumb_side * forwardKinematics(pose).joints[index_tip].position.x(),
              thumb_side * bent.joints[index_tip].position.x() + 0.005);
  }
}

TEST(HandPose, LeftIsTheMirrorImageOfRight) {
  HandPose pose = bentPose(Side::right);
  pose.wrist = Eigen::Isometry3d::Identity();
  const TrackedHand right = forwardKinematics(pose);
  pose.side = Side::left;
  const TrackedHand left = forwardKinematics(pose);
  for (int joint = 0; joint < joint_count; ++joint) {
    EXPECT_LT((mirrored(right.joints[joint].position) - left.joints[joint].position).norm(), 1e-12);
    // -Z and +Y mirror; +X is what makes the frame right-handed.
    for (const Vector3d& axis : {Vector3d(Vector3d::UnitZ()), Vector3d(Vector3d::UnitY())})
      EXPECT_LT(
          (mirrored(Vector3d(right.joints[joint].orientation * axis)) - left.joints[joint].orientation * axis)
              .norm(),
          1e-12);
  }
}

TEST(HandPose, LimitsAreTheTables) {
  HandPose pose;
  EXPECT_TRUE(withinLimits(pose));
  pose.fingers[1].flexion[0] = 99.0 * M_PI / 180.0;
  EXPECT_TRUE(withinLimits(pose));
  pose.fingers[1].flexion[0] = 101.0 * M_PI / 180.0;
  EXPECT_FALSE(withinLimits(pose));
  pose.fingers[1].flexion[0] = 0.0;
  pose.fingers[4].abduction = -31.0 * M_PI / 180.0;
  EXPECT_FALSE(withinLimits(pose));
}

TEST(HandCheck, KeepsTheMoreConfidentOfASide) {
  std::vector<TrackedHand> hands(4);
  for (int i = 0; i < 4; ++i) hands[i].id = i;
  hands[0].side = hands[3].side = Side::right;
  hands[0].confidence = 0.2;
  hands[3].confidence = 0.4;  // 1 and 2 are left hands of the same confidence
  EXPECT_EQ(keepOneHandASide(hands), 2U);
  ASSERT_EQ(hands.size(), 2U);
  EXPECT_EQ(hands[0].id, 3U);
  EXPECT_EQ(hands[1].id, 1U);
}

}  // namespace
}  // namespace tactile_clay::hand::pose_test
