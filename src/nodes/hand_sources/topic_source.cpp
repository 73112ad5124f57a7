#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <pluginlib/class_list_macros.hpp>

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "hand/hand_source.h"
#include "nodes/conversions.h"
#include "nodes/hand_sources/foreign_messages.h"

namespace tactile_clay::nodes {

/// Tracked hands of a ROS topic, such as one that `rosbag play` publishes or the driver of another package.
class TopicSource : public hand::HandSource {
 public:
  void open(const hand::SourceOptions& options) override {
    if (options.topic.empty()) throw std::runtime_error("hands from a topic: expected its name in 'topic'");
    ros::NodeHandle nh;  // not before: a source can be made, and asked, without a master
    nh.setCallbackQueue(&queue_);
    subscriber_ = subscribeToOthers<TrackedHands>(
        nh, options.topic, [this](const TrackedHands::ConstPtr& message) { newest_ = toCore(*message); },
        [this, name = nh.resolveName(options.topic)](const std::string& reason) {
          fault_ = "message on " + name + " left out: " + reason;
        });
  }

  Read read(hand::TrackedFrame& frame, std::chrono::milliseconds timeout) override {
    queue_.callAvailable(ros::WallDuration(std::chrono::duration<double>(timeout).count()));
    if (!newest_) return Read::nothing;
    frame = *std::exchange(newest_, std::nullopt);
    return Read::frame;
  }

  bool recorded() const override { return false; }
  bool cleaned() const override { return true; }
  std::string takeFault() override { return std::exchange(fault_, {}); }

 private:
  ros::CallbackQueue queue_;
  ros::Subscriber subscriber_;
  std::optional<hand::TrackedFrame> newest_;
  std::string fault_;
};

}  // namespace tactile_clay::nodes

PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::TopicSource, tactile_clay::hand::HandSource)
