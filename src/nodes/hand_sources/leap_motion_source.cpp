#include <ros/ros.h>
#include <pluginlib/class_list_macros.hpp>

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "hand/leap_frame.h"
#include "nodes/conversions.h"
#include "nodes/hand_sources/foreign_messages.h"
#include "nodes/hand_sources/leap_motion_message.h"
#include "nodes/hand_sources/topic_hands.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

using Human = LeapMotionHuman;
using nlohmann::json;

template <typename V>
json millimetres(const V& v) {
  return {1e3 * v.x, 1e3 * v.y, 1e3 * v.z};
}

/// Adds a hand in the format of protocol v6, from which the driver made it. So bones and left hands are
/// interpreted in one place only.
void add(const Human::Hand& hand, const char* side, json& frame) {
  if (!hand.present) return;
  json entry = {{"id", hand.id},
                {"type", side},
                {"confidence", hand.confidence},
                {"palmPosition", millimetres(hand.palm)},
                {"palmNormal", millimetres(hand.normal)},
                {"direction", millimetres(hand.direction)}};
  // If the driver sends no arm, the wrist is at the tracker's origin, where no hand is.
  if (hand.wrist.x != 0.0 || hand.wrist.y != 0.0 || hand.wrist.z != 0.0)
    entry["wrist"] = millimetres(hand.wrist);
  frame["hands"].push_back(std::move(entry));
  static constexpr std::array<const char*, 4> ends = {"mcpPosition", "pipPosition", "dipPosition",
                                                      "btipPosition"};
  for (const Human::Finger& finger : hand.fingers) {
    json pointable = {{"type", finger.type}, {"handId", hand.id}};
    for (const Human::Bone& bone : finger.bones) {
      if (bone.type == 0) pointable["carpPosition"] = millimetres(bone.start);
      if (bone.type < ends.size()) pointable[ends[bone.type]] = millimetres(bone.end);
    }
    frame["pointables"].push_back(std::move(pointable));
  }
}

}  // namespace

/// Hands of the driver ros-drivers/leap_motion.
class LeapMotionSource : public TopicHands {
 public:
  void open(const hand::SourceOptions& options) override {
    ros::NodeHandle nh;
    nh.setCallbackQueue(&queue_);
    // The default of all sources is the topic of recorded hands.
    const std::string topic = options.topic.empty() || options.topic == topic::hands_tracked
                                  ? "leap_motion/leap_device"
                                  : options.topic;
    name_ = nh.resolveName(topic);
    subscriber_ = subscribeToOthers<Human>(
        nh, name_, [this](const auto& human, const std::string&) { receive(human); },
        [this](const std::string& reason) { fault_ = "message on " + name_ + " left out: " + reason; });
  }

  std::string takeFault() override {
    if (subscriber_.getNumPublishers() == 0 && fault_.empty())
      return "nobody publishes " + name_ + ", expected leap_motion/Human";
    return TopicHands::takeFault();
  }

 private:
  void receive(const boost::shared_ptr<const Human>& human) {
    const auto now = std::chrono::steady_clock::now();
    json message = {{"timestamp", 0}, {"hands", json::array()}, {"pointables", json::array()}};
    add(human->right, "right", message);
    add(human->left, "left", message);
    auto frame = hand::parseLeapFrame(message.dump(), name_);
    if (!frame->dropped.empty()) fault_ = frame->dropped.back();
    newest_ = std::move(frame->frame);
    newest_->stamp = toCore(human->header.stamp);
    newest_->received = now;
  }

  ros::Subscriber subscriber_;
  std::string name_;
};

}  // namespace tactile_clay::nodes

PLUGINLIB_EXPORT_CLASS(tactile_clay::nodes::LeapMotionSource, tactile_clay::hand::HandSource)
