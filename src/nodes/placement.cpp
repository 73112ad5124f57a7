#include "nodes/placement.h"

#include <ros/console.h>

#include <algorithm>

#include "hand/hand_check.h"

namespace tactile_clay::nodes {

std::size_t leaveOutBadHands(hand::TrackedFrame& frame) {
  auto& hands = frame.hands;
  const std::size_t seen = hands.size();
  const auto bad = [](const hand::TrackedHand& hand) {
    const std::string fault = hand::faultOf(hand);
    if (!fault.empty()) ROS_WARN_THROTTLE(1.0, "hand left out: %s", fault.c_str());
    return !fault.empty();
  };
  hands.erase(std::remove_if(hands.begin(), hands.end(), bad), hands.end());
  return seen - hands.size();
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
