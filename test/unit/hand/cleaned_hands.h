#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "hand/hand_cleaner.h"
#include "hand/hand_pose.h"

/// Hands and their frames for the tests of the cleaner of hands.
namespace tactile_clay::hand {

inline TrackedHand handAt(const Eigen::Vector3d& position, std::uint32_t id = 1, Side side = Side::right,
                          double confidence = 1.0) {
  HandPose pose;
  pose.side = side;
  pose.wrist.translation() = position;
  TrackedHand hand = forwardKinematics(pose);
  hand.id = id;
  hand.confidence = confidence;
  return hand;
}

inline TrackedFrame frameOf(std::chrono::nanoseconds stamp, std::vector<TrackedHand> hands) {
  TrackedFrame frame;
  frame.stamp = stamp;
  frame.hands = std::move(hands);
  return frame;
}

inline TrackedFrame cleaned(HandCleaner& cleaner, std::chrono::nanoseconds stamp,
                            std::vector<TrackedHand> hands) {
  TrackedFrame frame = frameOf(stamp, std::move(hands));
  cleaner.clean(frame);
  return frame;
}

inline CleanConfig unfiltered() {
  CleanConfig config;
  config.position.min_cutoff = config.orientation.min_cutoff = 1e300;  // Hz: no filter
  return config;
}

inline const Eigen::Vector3d& palmOf(const TrackedFrame& frame) {
  return frame.hands.at(0).joints[palm].position;
}

}  // namespace tactile_clay::hand
