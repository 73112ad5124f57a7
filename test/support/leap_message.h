#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "hand/anatomy.h"
#include "hand/hand_pose.h"

namespace tactile_clay::hand {

/// Inverse of the conversion under test, written out.
inline nlohmann::json leapVector(const Eigen::Vector3d& v, double scale = 1e3) {
  return {-v.y() * scale, v.z() * scale, -v.x() * scale};
}

inline TrackedHand knownHand(Side side) {
  HandPose pose;
  pose.side = side;
  pose.scale = 1.05;
  pose.wrist = Eigen::Translation3d(-0.02, 0.05, 0.25) *
               Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitY()) *
               Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX());
  for (int finger = 0; finger < finger_count; ++finger) pose.fingers[finger].flexion = {0.2, 0.3, 0.4};
  return forwardKinematics(pose);
}

/// The message that a complete v6 service would send for a hand.
inline nlohmann::json leapMessage(const TrackedHand& hand, const nlohmann::json& id = 12) {
  const JointPose& p = hand.joints[palm];
  using nlohmann::json;
  json message = {{"id", 5}, {"timestamp", 1234567}, {"currentFrameRate", 100.0}};
  message["hands"] = {{{"id", id},
                       {"type", hand.side == Side::left ? "left" : "right"},
                       {"palmPosition", leapVector(p.position)},
                       {"palmNormal", leapVector(p.orientation * -Eigen::Vector3d::UnitY(), 1.0)},
                       {"direction", leapVector(p.orientation * -Eigen::Vector3d::UnitZ(), 1.0)},
                       {"confidence", 0.75},
                       {"wrist", leapVector(hand.joints[wrist].position)}}};
  message["pointables"] = json::array();
  for (int finger = 0; finger < finger_count; ++finger) {
    const FingerJoints& joints = fingers[finger];
    const auto at = [&](int i) { return leapVector(hand.joints[joints[joints.count - 4 + i]].position); };
    const json pointable_id = id.is_string() ? json(id.get<std::string>() + std::to_string(finger))
                                             : json(id.get<int>() * 10 + finger);
    message["pointables"].push_back({{"id", pointable_id},
                                     {"handId", id},
                                     {"type", finger},
                                     {"carpPosition", leapVector(hand.joints[joints[0]].position)},
                                     {"mcpPosition", at(0)},
                                     {"pipPosition", at(1)},
                                     {"dipPosition", at(2)},
                                     {"btipPosition", at(3)},
                                     {"tipPosition", at(3)}});
  }
  return message;
}

}  // namespace tactile_clay::hand
