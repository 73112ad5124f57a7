#include <ros/ros.h>
#include <pluginlib/class_list_macros.hpp>

#include <stdexcept>
#include <string>

#include "nodes/conversions.h"
#include "nodes/hand_sources/foreign_messages.h"
#include "nodes/hand_sources/topic_hands.h"
#include "nodes/player.h"

namespace tactile_clay::nodes {

/// Tracked hands of a ROS topic, such as one that `rosbag play` publishes or the driver of another package.
class TopicSource : public TopicHands {
 public:
  void open(const hand::SourceOptions& options) override {
    if (options.topic.empty()) throw std::runtime_error("hands from a topic: expected its name in 'topic'");
    // Made only here: a source can be constructed, and asked about itself, without a master.
    ros::NodeHandle nh;
    nh.setCallbackQueue(&queue_);
    subscriber_ = subscribeToOthers<TrackedHands>(
        nh, options.topic,
        [this](const auto& message, const std::string& publisher) {
          newest_ = toCore(*message);
          newest_->played = isPlayer(publisher);
        },
        [this, name = nh.resolveName(options.topic)](const std::string& reason) {
          fault_ = "message on " + name + " left out: " + reason;
        });
  }

  bool cleaned() const override { return true; }

 private:
  ros::Subscriber subscriber_;
};

}  // namespace tactile_clay::nodes

PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::TopicSource, tactile_clay::hand::HandSource)
