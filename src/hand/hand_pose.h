#pragma once

#include <Eigen/Geometry>
#include <array>

#include "hand/anatomy.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// Angles of a finger, rad. Zero: straight along the palm.
struct FingerAngles {
  std::array<double, 3> flexion{};  // MCP, PIP, DIP; of the thumb CMC, MP, IP
  double abduction = 0.0;           // positive toward the thumb; of the thumb: away from the palm
};

/// A hand by its 20 angles and the pose of its wrist.
struct HandPose {
  Side side = Side::right;
  Eigen::Isometry3d wrist = Eigen::Isometry3d::Identity();  // -Z along the palm to the fingers, +Y dorsal
  double scale = 1.0;                                       // of the person, relative to joint_anatomy
  std::array<FingerAngles, finger_count> fingers;
};

/// Forward kinematics: the 26 joints in the frame that the wrist is given in. A left hand is the mirror image
/// of a right one, with right-handed joint frames.
TrackedHand forwardKinematics(const HandPose& pose);

/// Whether every angle is inside finger_limits.
bool withinLimits(const HandPose& pose);

/// Frame of a bone: -Z along `direction`, +X as near to `flexion_axis` as possible.
Eigen::Quaterniond boneOrientation(const Eigen::Vector3d& direction, const Eigen::Vector3d& flexion_axis);

/// Mirror image in the plane x = 0. For a rotation, the frame of the image is right-handed again.
inline Eigen::Vector3d mirrored(const Eigen::Vector3d& v) {
  return {-v.x(), v.y(), v.z()};
}
inline Eigen::Quaterniond mirrored(const Eigen::Quaterniond& q) {
  return {q.w(), q.x(), -q.y(), -q.z()};
}

}  // namespace tactile_clay::hand
