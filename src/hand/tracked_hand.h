#pragma once

#include <Eigen/Geometry>
#include <array>
#include <bitset>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace tactile_clay::hand {

enum class Side : std::uint8_t { left = 0, right = 1 };

/// Joints in the order of OpenXR `XR_EXT_hand_tracking`.
enum Joint : int {
  palm,
  wrist,
  thumb_metacarpal,
  thumb_proximal,
  thumb_distal,
  thumb_tip,
  index_metacarpal,
  index_proximal,
  index_intermediate,
  index_distal,
  index_tip,
  middle_metacarpal,
  middle_proximal,
  middle_intermediate,
  middle_distal,
  middle_tip,
  ring_metacarpal,
  ring_proximal,
  ring_intermediate,
  ring_distal,
  ring_tip,
  little_metacarpal,
  little_proximal,
  little_intermediate,
  little_distal,
  little_tip,
  joint_count
};

/// Pose of one joint: -Z points toward the tip, +Y is dorsal (OpenXR).
struct JointPose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // m
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  double radius = 0.0;  // m
};

/// A joint that a source could not read.
struct UnreadJoint {
  Joint joint;
  std::string why;  // one line, without the name of the joint
};

struct TrackedHand {
  std::uint32_t id = 0;  // the tracker's id; a new id does not mean a new hand
  Side side = Side::left;
  double confidence = 1.0;  // 0-1
  std::array<JointPose, joint_count> joints;
  /// Joints of fingers that were not seen, or were not where a hand has them (hand_check.h); never palm and
  /// wrist. Their poses have no meaning. In messages they lie at the wrist, with radius 0.
  std::bitset<joint_count> missing;
  /// Joints that the source could not read, for `judge` (hand_check.h), which makes them missing and reports
  /// them. It leaves none behind.
  std::vector<UnreadJoint> unread;
};

/// One sample of a tracker: every hand it sees, in the frame `frame_id`.
struct TrackedFrame {
  /// By the source's own clock; ROS time if `frame_id` is that of a ROS recording.
  std::chrono::nanoseconds stamp{0};
  std::string frame_id = "tracker";
  std::vector<TrackedHand> hands;
  bool played = false;  // by rosbag play; its hands may stand still, those of a tracker tremble
  std::chrono::steady_clock::time_point received;  // when it reached this machine; not set by recordings
};

}  // namespace tactile_clay::hand
