#pragma once

#include <string>

#include "hand/anatomy.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// How the joints of a skeleton are numbered: finger by finger from the root; for each bone first abduction,
/// if it has one, then flexion.

constexpr int bone_count = 3;  // moving bones of a finger

/// Number of a finger's first joint in the list of joints, and how many joints it has there.
constexpr int firstAngle(int finger) {
  return finger == 0 ? 0 : 4 * finger + 1;
}
constexpr int angleCount(int finger) {
  return finger == 0 ? 5 : 4;
}
constexpr bool hasAbduction(int finger, int bone) {
  return bone == 0 || (finger == 0 && bone == 1);
}

struct JointPlace {
  int finger, bone;
  bool abduction;
};
JointPlace placeOf(int joint);

/// The moving joints of a finger: of bone i from movingJoint(finger, i) to movingJoint(finger, i + 1).
Joint movingJoint(int finger, int i);

/// Prefix of all names of links and joints of a side.
std::string skeletonPrefix(Side side);

/// Name of a finger, such as `index`.
const char* skeletonFinger(int finger);

}  // namespace tactile_clay::hand
