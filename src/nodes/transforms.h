#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/spinner.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>

#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "nodes/throttle.h"

namespace tactile_clay::nodes {

/// Empty, or what is wrong with a transform that somebody sent, and what was expected.
std::string faultOf(const geometry_msgs::TransformStamped& transform);

/// Newest poses of coordinate frames, from `/tf` and `/tf_static`.
///
/// tf2's own listener ends its process on some stamps, and prints a line for each transform that goes back in
/// time or repeats itself. Only the newest pose of a frame is ever asked for here, so transforms are kept
/// without their stamps: the last one to arrive counts. A frame that `/tf_static` placed is moved by
/// `/tf_static` only. tf2 keeps the name of every frame for ever, so a transform that would name more than
/// 1000 frames is left out.
class Transforms {
 public:
  Transforms();
  ~Transforms();

  /// Pose of `source` in `target`. Waits for it at most `patience` of wall time. After a failure it does not
  /// wait again until a lookup has succeeded.
  /// @return nothing, after one throttled line, if tf does not know the pose
  std::optional<Eigen::Isometry3d> lookup(const std::string& target, const std::string& source,
                                          ros::WallDuration patience = ros::WallDuration(5.0));

 private:
  struct Frame {
    std::string parent;  // empty until a transform places the frame
    bool fixed = false;  // placed by /tf_static
  };

  void receive(const tf2_msgs::TFMessage& message, bool fixed);
  bool isAbove(const std::string& frame, std::string below) const;
  void take(const geometry_msgs::TransformStamped& transform, bool fixed);
  void refuse(const std::string& topic, const std::string& reason);

  tf2::BufferCore buffer_;
  std::map<std::string, Frame> frames_;  // all frames that were named
  Throttle lines_;
  bool patient_ = true;

  ros::CallbackQueue queue_;  // served by a thread of its own, so that a callback can wait for a transform
  ros::Subscriber moving_, fixed_;
  std::unique_ptr<ros::AsyncSpinner> spinner_;
};

/// Sends the moving transforms of a node. A transform is not sent if its stamp is not later than the last one
/// of its frame: tf would not take it, and every listener would print a line. A transform with a stamp of the
/// future is not sent, either, because tf would then take no other one.
class MovingTransforms {
 public:
  void send(const geometry_msgs::TransformStamped& transform);

 private:
  tf2_ros::TransformBroadcaster broadcaster_;
  std::map<std::string, ros::Time> sent_;  // newest stamp of each frame
};

/// Static transforms of this process. All its nodes share one latched publisher: with one publisher per node,
/// a listener that comes late may be given the latched transforms of one node only.
class StaticTransforms {
 public:
  /// The broadcaster of the process; lives as long as a pointer to it exists.
  static std::shared_ptr<StaticTransforms> shared();

  void send(const geometry_msgs::TransformStamped& transform);

 private:
  std::mutex mutex_;
  tf2_ros::StaticTransformBroadcaster broadcaster_;
};

geometry_msgs::TransformStamped transformMessage(const std::string& parent, const std::string& child,
                                                 const Eigen::Isometry3d& pose, ros::Time stamp);

}  // namespace tactile_clay::nodes
