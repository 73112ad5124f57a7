#pragma once

#include <ros/ros.h>
#include <tactile_clay/TrackedHands.h>
#include <tf2_ros/transform_broadcaster.h>

#include <string>

#include "hand/kinematic_hand.h"
#include "nodes/health.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {

/// Puts skin on tracked hands: one `hands/skin` for each `hands/tracked`, with its stamp, in `world`; without
/// fields changing, and without points, where no hand is seen. Broadcasts the palms as `hand_left` and
/// `hand_right`.
class HandSimulator {
 public:
  /// \throws std::runtime_error, std::invalid_argument with one line where a parameter is wrong
  HandSimulator(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  void receive(const TrackedHands::ConstPtr& message);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  std::string world_;
  hand::KinematicHands hands_;
  Transforms transforms_;
  tf2_ros::TransformBroadcaster broadcaster_;
  unsigned frames_ = 0, bad_hands_ = 0;
  std::size_t samples_ = 0;

  ros::Subscriber subscriber_;
  ros::Publisher publisher_;
  Health health_;
};

}  // namespace tactile_clay::nodes
