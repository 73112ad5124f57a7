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

/// Puts skin on tracked hands: publishes one `hands/skin` for each `hands/tracked`, with its stamp, in
/// `world`. If no hand is seen, the cloud has no points. Broadcasts the palms as the coordinate frames
/// `hand_left` and `hand_right`.
///
/// Every message is judged (hand_check.h): hands that are wrong, fingers that are missing and hands that jump
/// get no skin. With `~live_input`, which is for `hands/tracked` of another program, hands that are only
/// repeated get no skin, either, unless they are played (player.h, repeated_hands.h).
///
/// `~hand_model` is `kinematic` (the skin moves with the tracked bones) or `soft` (bones and flesh are
/// between the tracked pose and the clay, whose forces come with `clay/contacts`). For soft hands the
/// following applies, too. In lockstep a tracker sample waits until the clay has answered the skin before it,
/// and so always meets the forces of that skin. A cloud with points has the fields `tracked_x` to
/// `tracked_area`: position, normal and area of each skin sample on the tracked hand, where it is felt. While
/// somebody subscribes, `hands/bones` has the bones of the tracked hand beside those of the virtual hand,
/// which the clay may hold back.
class HandSimulator {
 public:
  /// @throws std::runtime_error, std::invalid_argument with one line if a parameter is wrong
  HandSimulator(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  void receive(const TrackedHands::ConstPtr& message, const std::string& publisher);
  void react(const sensor_msgs::PointCloud2::ConstPtr& contacts);
  void simulateWaiting();
  void simulate(hand::TrackedFrame frame);
  void showBones(const hand::TrackedFrame& frame, const std_msgs::Header& header);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  std::string world_;
  std::unique_ptr<hand::KinematicHands> kinematic_;  // one of these two is set
  std::unique_ptr<hand::SoftHands> soft_;
  bool lockstep_, live_input_;
  hand::JumpCheck jumps_;
  hand::RepeatedHands repeats_{repeats_patience};
  std::deque<hand::TrackedFrame> waiting_;
  std::optional<ros::Time> awaited_;  // soft and lockstep: stamp of the skin that the clay has yet to answer
  Transforms transforms_;
  MovingTransforms broadcaster_;
  FrameTimes times_;             // times of making the skin
  double processor_time_ = 0.0;  // s, for the same frames
  unsigned bad_hands_ = 0, bad_fingers_ = 0, repeated_hands_ = 0;
  std::size_t samples_ = 0, bad_forces_ = 0;

  Inbox inbox_;
  ros::Subscriber subscriber_, contacts_;
  ros::Publisher publisher_, bones_;
  Health health_;
};

}  // namespace tactile_clay::nodes
