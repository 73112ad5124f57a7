#include "nodes/transforms.h"

#include <tf2_eigen/tf2_eigen.h>

#include <cmath>

#include "nodes/exit_code.h"
#include "nodes/frame_name.h"
#include "nodes/inbox.h"
#include "nodes/stamps.h"
#include "values/text.h"

namespace tactile_clay::nodes {
namespace {

constexpr std::size_t max_frames = 1000;  // names of coordinate frames, parents too: tf2 keeps each of them
constexpr std::size_t max_transforms = 1000;  // transforms of one message
constexpr double farthest = 1e6;              // m
constexpr double unit_tolerance = 1e-6;       // tolerance of a squared norm, as in tf2

}  // namespace

std::string faultOf(const geometry_msgs::TransformStamped& transform) {
  const std::string parent = frameName(transform.header.frame_id);
  const std::string child = frameName(transform.child_frame_id);
  const auto& p = transform.transform.translation;
  const auto& q = transform.transform.rotation;
  std::string fault = faultOfHeader(nullptr, &parent);
  if (fault.empty()) fault = faultOfHeader(nullptr, &child);
  if (!fault.empty()) return fault;
  if (parent.empty() || child.empty() || parent == child)
    return "transform from '" + parent + "' to '" + child + "', expected the names of two frames";
  // Written so that NaN fails.
  if (!(std::abs(p.x) < farthest && std::abs(p.y) < farthest && std::abs(p.z) < farthest))
    return "frame '" + child + "' at a position that is not finite, expected numbers in m";
  if (!(std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1.0) <= unit_tolerance))
    return "frame '" + child + "' has no valid orientation, expected a unit quaternion";
  return "";
}

Transforms::Transforms() {
  ros::NodeHandle nh;
  nh.setCallbackQueue(&queue_);
  const auto listen = [&](const char* topic, bool fixed) {
    return subscribe<tf2_msgs::TFMessage>(
        nh, topic, 100,
        [this, fixed](const tf2_msgs::TFMessage::ConstPtr& message) { receive(*message, fixed); },
        [this, topic](const std::string& reason) { refuse(topic, reason); });
  };
  moving_ = listen("/tf", false);
  fixed_ = listen("/tf_static", true);
  spinner_ = std::make_unique<ros::AsyncSpinner>(1, &queue_);
  spinner_->start();
}

Transforms::~Transforms() {
  spinner_->stop();
}

void Transforms::receive(const tf2_msgs::TFMessage& message, bool fixed) {
  if (message.transforms.size() > max_transforms)
    throw std::runtime_error(std::to_string(message.transforms.size()) + " transforms, expected at most " +
                             std::to_string(max_transforms));
  for (const geometry_msgs::TransformStamped& transform : message.transforms) take(transform, fixed);
}

void Transforms::take(const geometry_msgs::TransformStamped& transform, bool fixed) {
  const char* topic = fixed ? "/tf_static" : "/tf";
  const std::string fault = faultOf(transform);
  if (!fault.empty()) return refuse(topic, fault);
  // tf2 itself removes one slash only: its buffer gets the names that are counted here.
  geometry_msgs::TransformStamped named = transform;
  const std::string& parent = named.header.frame_id = frameName(transform.header.frame_id);
  const std::string& child = named.child_frame_id = frameName(transform.child_frame_id);
  const auto known = frames_.find(child);
  const std::size_t fresh = (known == frames_.end() ? 1 : 0) + (frames_.count(parent) == 0 ? 1 : 0);
  if (frames_.size() + fresh > max_frames)
    return refuse(topic, "transform from '" + parent + "' to '" + child + "', expected at most " +
                             std::to_string(max_frames) + " coordinate frames, parents among them");
  if (known != frames_.end() && known->second.fixed && !fixed)
    return refuse(topic, "frame '" + child + "' moves, expected it to stay where /tf_static says");
  if (isAbove(child, parent))
    return refuse(topic, "frame '" + parent + "' is below '" + child + "' already, expected no loop");
  frames_[child] = {parent, fixed};
  frames_.try_emplace(parent);
  buffer_.setTransform(named, "tf", true);
}

/// Whether `below` is attached to `frame`, directly or through others. There are no loops, because none is
/// accepted.
bool Transforms::isAbove(const std::string& frame, std::string below) const {
  for (auto at = frames_.find(below); at != frames_.end(); at = frames_.find(below = at->second.parent))
    if (at->second.parent == frame) return true;
  return false;
}

void Transforms::refuse(const std::string& topic, const std::string& reason) {
  if (const auto more = lines_.pass())
    ROS_WARN("transform on %s left out%s: %s", topic.c_str(), andMore(*more).c_str(),
             values::printableLine(reason).c_str());
}

namespace {

bool isFrameName(const std::string& frame) {
  return !frame.empty() && frame.front() != '/';
}

}  // namespace

std::optional<Eigen::Isometry3d> Transforms::lookup(const std::string& into, const std::string& from,
                                                    ros::WallDuration patience) {
  const std::string target = frameName(into), source = frameName(from);
  if (target == source) return Eigen::Isometry3d::Identity();
  const ros::WallTime deadline = ros::WallTime::now() + patience;
  // tf2 prints a line for each lookup of an invalid name.
  const bool named = isFrameName(target) && isFrameName(source);
  // Waits by the wall clock: with use_sim_time, ROS time may stand still.
  while (named && patient_ && ros::ok() && !buffer_.canTransform(target, source, ros::Time(0)) &&
         ros::WallTime::now() < deadline)
    ros::WallDuration(0.005).sleep();
  try {
    const auto pose = tf2::transformToEigen(buffer_.lookupTransform(target, source, ros::Time(0)));
    patient_ = true;
    return Eigen::Isometry3d(pose.matrix());
  } catch (const std::exception& error) {
    patient_ = false;
    ROS_ERROR_THROTTLE(5.0,
                       "no transform from frame '%s' to '%s': %s; expected a node that publishes it, such as "
                       "static_transform_publisher of tf2_ros",
                       values::printableLine(source).c_str(), values::printableLine(target).c_str(),
                       values::printableLine(error.what()).c_str());
    return std::nullopt;
  }
}

void MovingTransforms::send(const geometry_msgs::TransformStamped& transform) {
  if (!nodes::faultOf(transform).empty() || !nodes::faultOf(transform.header.stamp).empty() ||
      isOfTheFuture(transform.header.stamp, ros::Time::now()))
    return;
  ros::Time& newest = sent_[transform.child_frame_id];
  if (!(newest < transform.header.stamp)) return;
  newest = transform.header.stamp;
  broadcaster_.sendTransform(transform);
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
