#include "nodes/transforms.h"

#include <tf2_eigen/tf2_eigen.h>

#include "nodes/exit_code.h"

namespace tactile_clay::nodes {

std::optional<Eigen::Isometry3d> Transforms::lookup(const std::string& target, const std::string& source,
                                                    ros::Time stamp, ros::WallDuration patience) {
  if (target == source) return Eigen::Isometry3d::Identity();
  const ros::WallTime deadline = ros::WallTime::now() + patience;
  // Waits by the wall clock: with use_sim_time, ROS time may stand still.
  while (patient_ && ros::ok() && !buffer_.canTransform(target, source, stamp) &&
         ros::WallTime::now() < deadline)
    ros::WallDuration(0.005).sleep();
  try {
    const auto pose = tf2::transformToEigen(buffer_.lookupTransform(target, source, stamp));
    patient_ = true;
    return Eigen::Isometry3d(pose.matrix());
  } catch (const tf2::TransformException& error) {
    patient_ = false;
    ROS_ERROR_THROTTLE(5.0, "no transform from frame '%s' to '%s': %s", source.c_str(), target.c_str(),
                       error.what());
    return std::nullopt;
  }
}

std::shared_ptr<StaticTransforms> StaticTransforms::shared() {
  static std::mutex mutex;
  static std::weak_ptr<StaticTransforms> instance;
  const std::lock_guard<std::mutex> lock(mutex);
  std::shared_ptr<StaticTransforms> current = instance.lock();
  if (!current) instance = current = std::make_shared<StaticTransforms>();
  return current;
}

void StaticTransforms::send(const geometry_msgs::TransformStamped& transform) {
  const std::lock_guard<std::mutex> lock(mutex_);
  // A broadcaster that was made after Ctrl-C has no publisher, and would end the process with a signal.
  if (!shuttingDown()) broadcaster_.sendTransform(transform);
}

geometry_msgs::TransformStamped transformMessage(const std::string& parent, const std::string& child,
                                                 const Eigen::Isometry3d& pose, ros::Time stamp) {
  geometry_msgs::TransformStamped message = tf2::eigenToTransform(pose);
  message.header.stamp = stamp;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  return message;
}

}  // namespace tactile_clay::nodes
