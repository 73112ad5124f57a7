#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <tactile_clay/TrackedHands.h>

#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "hand/jump_check.h"
#include "hand/kinematic_hand.h"
#include "hand/repeated_hands.h"
#include "hand/soft_hands.h"
#include "nodes/frame_times.h"
#include "nodes/health.h"
#include "nodes/inbox.h"
#include "nodes/placement.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {

/// Puts skin on tracked hands: one `hands/skin` for each `hands/tracked`, with its stamp, in `world`; without
/// fields changing, and without points, where no hand is seen. Broadcasts the palms as `hand_left` and
/// `hand_right`.
///
/// Whatever comes is judged (hand_check.h): hands that are none, fingers that are not there and hands that
/// jump have no skin. With `~live_input`, as where another program publishes `hands/tracked`, neither have
/// hands that are only repeated with fresh stamps (repeated_hands.h).
///
/// `~hand_model` is `kinematic` (skin moves with the tracked bones) or `soft` (bones and flesh between the
/// tracked pose and the clay, of which `clay/contacts` tells the forces). Soft and in lockstep, a sample
/// waits until the clay has answered the skin before it, and so always meets the forces of that one. Soft,
/// the skin has the fields `tracked_x` to `tracked_area`: the place, normal and area of each sample on the
/// tracked hand, where it is felt. Soft, and where somebody looks, `hands/bones` has the bones of the tracked
/// hand beside those that the clay holds.
class HandSimulator {
 public:
  /// @throws std::runtime_error, std::invalid_argument with one line where a parameter is wrong
  HandSimulator(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  void receive(const TrackedHands::ConstPtr& message);
  void react(const sensor_msgs::PointCloud2::ConstPtr& contacts);
  void simulateWaiting();
  void simulate(const TrackedHands& message);
  void showBones(const hand::TrackedFrame& frame, const std_msgs::Header& header);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  std::string world_;
  std::unique_ptr<hand::KinematicHands> kinematic_;  // one of the two
  std::unique_ptr<hand::SoftHands> soft_;
  bool lockstep_, live_input_;
  hand::JumpCheck jumps_;
  hand::RepeatedHands repeats_{repeats_patience};
  std::deque<TrackedHands::ConstPtr> waiting_;
  std::optional<ros::Time> awaited_;  // soft and lockstep: stamp of the skin that the clay has yet to answer
  Transforms transforms_;
  MovingTransforms broadcaster_;
  FrameTimes times_;             // for the skin
  double processor_time_ = 0.0;  // s, for them
  unsigned bad_hands_ = 0, bad_fingers_ = 0, repeated_hands_ = 0;
  std::size_t samples_ = 0, bad_forces_ = 0;

  Inbox inbox_;
  ros::Subscriber subscriber_, contacts_;
  ros::Publisher publisher_, bones_;
  Health health_;
};

}  // namespace tactile_clay::nodes
