#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/ros.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_listener.h>

#include <Eigen/Geometry>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace tactile_clay::nodes {

/// Poses of frames by tf2.
class Transforms {
 public:
  Transforms() : listener_(buffer_, true) {}

  /// Pose of `source` in `target` at `stamp`. Waits for it at most `patience` of wall time; an unknown pair
  /// of frames is waited for only once. \return nothing, after one throttled line, where tf does not know it
  std::optional<Eigen::Isometry3d> lookup(const std::string& target, const std::string& source,
                                          ros::Time stamp,
                                          ros::WallDuration patience = ros::WallDuration(5.0));

 private:
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_;
  bool patient_ = true;
};

/// Static transforms of this process. All its nodes share one latched publisher: with one each, a listener
/// that comes late may be given the latched transforms of one node only.
class StaticTransforms {
 public:
  /// The broadcaster of the process; lives as long as somebody holds it.
  static std::shared_ptr<StaticTransforms> shared();

  void send(const geometry_msgs::TransformStamped& transform);

 private:
  std::mutex mutex_;
  tf2_ros::StaticTransformBroadcaster broadcaster_;
};

geometry_msgs::TransformStamped transformMessage(const std::string& parent, const std::string& child,
                                                 const Eigen::Isometry3d& pose, ros::Time stamp);

}  // namespace tactile_clay::nodes
