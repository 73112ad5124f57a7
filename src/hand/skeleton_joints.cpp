#include "hand/skeleton_joints.h"

#include <array>

#include "hand/skeleton.h"

namespace tactile_clay::hand {
namespace {

constexpr double thumb_mp_abduction = 10.0 * degree;
const std::array<const char*, finger_count> finger_names = {"thumb", "index", "middle", "ring", "little"};
const std::array<const char*, bone_count> thumb_names = {"cmc", "mp", "ip"};
const std::array<const char*, bone_count> names_of_fingers = {"mcp", "pip", "dip"};

}  // namespace

JointPlace placeOf(int joint) {
  const int finger = joint < firstAngle(1) ? 0 : (joint - 1) / 4;
  int first = firstAngle(finger);  // first joint of the bone
  for (int bone = 0;; ++bone) {
    const int flexion = first + (hasAbduction(finger, bone) ? 1 : 0);
    if (joint <= flexion) return {finger, bone, joint < flexion};
    first = flexion + 1;
  }
}

Joint movingJoint(int finger, int i) {
  return fingers[finger][(finger == 0 ? 0 : 1) + i];
}

std::string skeletonPrefix(Side side) {
  return side == Side::left ? "hand_left_" : "hand_right_";
}

const char* skeletonFinger(int finger) {
  return finger_names[finger];
}

Eigen::Vector2d skeletonLimits(int joint) {
  const JointPlace place = placeOf(joint);
  const FingerLimits& limits = finger_limits[place.finger];
  if (!place.abduction) return limits.flexion[place.bone];
  return place.bone == 0 ? limits.abduction : Eigen::Vector2d(-thumb_mp_abduction, thumb_mp_abduction);
}

std::string skeletonJointName(Side side, int joint) {
  const JointPlace place = placeOf(joint);
  const auto& names = place.finger == 0 ? thumb_names : names_of_fingers;
  return skeletonPrefix(side) + finger_names[place.finger] + "_" + names[place.bone] +
         (place.abduction ? "_abduction" : "_flexion");
}

}  // namespace tactile_clay::hand
