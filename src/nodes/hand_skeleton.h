#pragma once

#include <ros/ros.h>
#include <tactile_clay/TrackedHands.h>

#include <array>
#include <optional>
#include <vector>

#include "hand/skeleton.h"
#include "nodes/health.h"
#include "nodes/inbox.h"
#include "nodes/joint_relay.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {

/// Shows tracked hands as joint angles of an anatomical skeleton, for robot_state_publisher and rviz.
///
/// A side is measured from its first 30 samples. Then its URDF is parameter `~robot_description_left` or
/// `~robot_description_right`, and each sample gives `hands/joint_states_left` or `hands/joint_states_right`
/// and the transform of its wrist in `world`, with the sample's stamp. A hand that is gone has no place: its
/// wrist hangs on frame `hand_left_lost` or `hand_right_lost`, which is not part of the world's tree, so that
/// tf and rviz say so.
class HandSkeleton {
 public:
  /// @throws std::runtime_error with one line where a parameter is wrong
  HandSkeleton(ros::NodeHandle nh, ros::NodeHandle private_nh);
  ~HandSkeleton();

 private:
  struct State {
    std::vector<hand::TrackedHand> samples;  // until there are enough
    std::optional<hand::Skeleton> skeleton;
    std::optional<hand::SkeletonPose> pose;  // while the hand is there
    double error_sum = 0.0;                  // m, of the last second
    unsigned frames = 0;
    ros::Publisher publisher;
  };

  void forgetModels();
  void receive(const TrackedHands& message);
  void follow(hand::Side side, const hand::TrackedHand* tracked, const ros::Time& stamp);
  void measure(State& state, const hand::TrackedHand& tracked);
  void sendWrist(hand::Side side, const std::string& parent, const Eigen::Isometry3d& pose,
                 const ros::Time& stamp);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle nh_;
  std::string world_;
  std::array<State, 2> sides_;
  Transforms transforms_;
  MovingTransforms broadcaster_;
  Inbox inbox_;
  JointRelay left_joints_, right_joints_;
  ros::Subscriber subscriber_;
  Health health_;
};

}  // namespace tactile_clay::nodes
