#include "hand/placed_hand.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hand/hand_shape.h"

namespace tactile_clay::hand {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

Eigen::Isometry3d palmDown(double pitch) {
  Eigen::Matrix3d rotation;
  rotation << -Vector3d::UnitY(), Vector3d::UnitZ(), -Vector3d::UnitX();
  return Eigen::Isometry3d(rotation * AngleAxisd(-pitch, Vector3d::UnitX()));
}

HandPose curled(Side side, double scale, double mcp, double pip, double dip) {
  HandPose pose;
  pose.side = side;
  pose.scale = scale;
  pose.fingers[0].abduction = -10 * degree;
  for (int finger = 1; finger < finger_count; ++finger) pose.fingers[finger].flexion = {mcp, pip, dip};
  return pose;
}

double smallest(const TrackedHand& hand, const std::function<double(const Vector3d&, double)>& measure) {
  constexpr int steps = 16;
  double minimum = std::numeric_limits<double>::infinity();
  for (const Bone& bone : bones) {
    const Capsule capsule = boneCapsule(bone, hand);
    for (int i = 0; i <= steps; ++i) {
      const double u = static_cast<double>(i) / steps;
      minimum = std::min(minimum, measure(capsule.centre(u), capsule.radius(u)));
    }
  }
  return minimum;
}

HandPose placed(HandPose pose, const Eigen::Isometry3d& orientation, Joint joint, const Vector3d& target) {
  pose.wrist = orientation;
  const TrackedHand hand = forwardKinematics(pose);
  const Vector3d& at = hand.joints[joint].position;
  const double lowest =
      smallest(hand, [](const Vector3d& centre, double radius) { return centre.z() - radius; });
  pose.wrist.pretranslate(Vector3d(target.x() - at.x(), target.y() - at.y(), target.z() - lowest));
  return pose;
}

HandPose lifted(HandPose pose, double z) {
  pose.wrist.pretranslate(Vector3d(0.0, 0.0, z));
  return pose;
}

}  // namespace tactile_clay::hand
