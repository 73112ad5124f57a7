#include "nodes/placement.h"

#include <ros/console.h>

#include <mutex>

#include "nodes/throttle.h"
#include "values/text.h"

namespace tactile_clay::nodes {

void tell(const hand::LeftOut& left_out) {
  if (left_out.lines.empty()) return;
  // Shared by all nodes of this process, because they see the same hands.
  static std::mutex mutex;
  static Throttle throttle(1.0);
  const std::lock_guard<std::mutex> lock(mutex);
  const auto held = throttle.pass();
  if (!held) return;
  std::string words;
  for (const std::string& line : left_out.lines) words += (words.empty() ? "" : "; ") + line;
  ROS_WARN("%s", (values::printableLine(words) + andMore(*held)).c_str());
}

hand::LeftOut leaveOutBadHands(hand::TrackedFrame& frame) {
  hand::LeftOut left_out = hand::leaveOutBadHands(frame.hands);
  tell(left_out);
  return left_out;
}

void placeInWorld(hand::TrackedFrame& frame, const std::string& world, Transforms& transforms) {
  if (frame.frame_id != world && !frame.hands.empty()) {
    const auto pose = transforms.lookup(world, frame.frame_id);
    if (!pose) frame.hands.clear();
    for (hand::TrackedHand& hand : frame.hands)
      for (hand::JointPose& joint : hand.joints) {
        joint.position = *pose * joint.position;
        joint.orientation = Eigen::Quaterniond(pose->rotation()) * joint.orientation;
      }
  }
  frame.frame_id = world;
}

}  // namespace tactile_clay::nodes
