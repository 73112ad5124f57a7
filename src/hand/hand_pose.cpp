#include "hand/hand_pose.h"

namespace tactile_clay::hand {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// Flexion turns the tip (-Z) toward the palm (-Y), abduction turns it toward the thumb (-X of a right hand).
Quaterniond bend(double flexion, double abduction = 0.0) {
  return AngleAxisd(abduction, Vector3d::UnitY()) * AngleAxisd(-flexion, Vector3d::UnitX());
}

// Places the joints of a finger in the palm's frame of a right hand.
void placeFinger(int finger, const HandPose& pose, TrackedHand& hand) {
  const FingerJoints& joints = fingers[finger];
  const FingerAngles& angles = pose.fingers[finger];
  const PalmAnatomy& palm_part = palm_anatomy[finger];
  const Quaterniond metacarpal = boneOrientation(palm_part.knuckle - palm_part.base, palm_part.flexion_axis);
  Vector3d position = palm_part.base * pose.scale;
  Quaterniond orientation = metacarpal;
  for (int i = 0, bent = 0; i < joints.count; ++i) {
    const int first_bent = joints.first == thumb_metacarpal ? 0 : 1;
    if (i > 0)
      position += orientation * Vector3d(0.0, 0.0, -joint_anatomy[joints[i]].bone_length * pose.scale);
    if (i == first_bent) {
      const Quaterniond straight =
          finger == 0 ? metacarpal : boneOrientation(-Vector3d::UnitZ(), palm_part.flexion_axis);
      orientation = straight * bend(angles.flexion[bent++], angles.abduction);
    } else if (i > first_bent && bent < 3) {
      orientation = orientation * bend(angles.flexion[bent++]);
    }  // the tip keeps the frame of the last bone
    hand.joints[joints[i]].position = position;
    hand.joints[joints[i]].orientation = orientation.normalized();
  }
}

}  // namespace

Quaterniond boneOrientation(const Vector3d& direction, const Vector3d& flexion_axis) {
  Eigen::Matrix3d frame;
  frame.col(2) = -direction.normalized();
  const Vector3d x = flexion_axis - flexion_axis.dot(frame.col(2)) * frame.col(2);
  // If the direction is that of the axis, no X is nearest: any perpendicular one serves.
  frame.col(0) = x.norm() > 1e-6 ? x.normalized() : Vector3d(frame.col(2).unitOrthogonal());
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return Quaterniond(frame);
}

TrackedHand forwardKinematics(const HandPose& pose) {
  TrackedHand hand;
  hand.side = pose.side;
  hand.joints[wrist].position = wrist_in_palm * pose.scale;
  for (int finger = 0; finger < finger_count; ++finger) placeFinger(finger, pose, hand);
  const Quaterniond rotation(pose.wrist.rotation());
  const Vector3d from_wrist = hand.joints[wrist].position;
  for (int joint = 0; joint < joint_count; ++joint) {
    JointPose& j = hand.joints[joint];
    j.position -= from_wrist;
    if (pose.side == Side::left) {
      j.position = mirrored(j.position);
      j.orientation = mirrored(j.orientation);
    }
    j.position = pose.wrist * j.position;
    j.orientation = (rotation * j.orientation).normalized();
    j.radius = joint_anatomy[joint].radius * pose.scale;
  }
  return hand;
}

bool withinLimits(const HandPose& pose) {
  constexpr double rounding = 1e-9;
  const auto inside = [](double angle, const Eigen::Vector2d& range) {
    return angle >= range[0] - rounding && angle <= range[1] + rounding;
  };
  for (int finger = 0; finger < finger_count; ++finger) {
    const FingerLimits& limit = finger_limits[finger];
    if (!inside(pose.fingers[finger].abduction, limit.abduction)) return false;
    for (int i = 0; i < 3; ++i)
      if (!inside(pose.fingers[finger].flexion[i], limit.flexion[i])) return false;
  }
  return true;
}

}  // namespace tactile_clay::hand
