#pragma once

#include <string>

#include "hand/hand_pose.h"

/// A hand for the tests of what is no hand, and how its joints and the lines about it are compared.
namespace tactile_clay::hand {

inline HandPose bentPose(Side side, double scale = 1.05) {
  HandPose pose;
  pose.side = side;
  pose.scale = scale;
  pose.wrist = Eigen::Translation3d(0.1, -0.2, 0.3) *
               Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, -2.0, 0.5).normalized());
  for (FingerAngles& finger : pose.fingers) finger.flexion = {0.3, 0.3, 0.25};
  return pose;
}

inline TrackedHand bentHand(Side side = Side::right, double scale = 1.05) {
  TrackedHand hand = forwardKinematics(bentPose(side, scale));
  hand.id = 7;
  return hand;
}

inline bool sameBits(const JointPose& a, const JointPose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs() && a.radius == b.radius;
}

inline bool contains(const std::string& line, const std::string& part) {
  return line.find(part) != std::string::npos && line.find('\n') == std::string::npos;
}

}  // namespace tactile_clay::hand
