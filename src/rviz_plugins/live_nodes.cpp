#include "rviz_plugins/live_nodes.h"

#include <ros/ros.h>

#include <mutex>
#include <set>
#include <thread>
#include <utility>

namespace tactile_clay::rviz_plugins {
namespace {

using dynamic_reconfigure::Config;
using dynamic_reconfigure::ConfigDescription;

struct Node {
  ConfigDescription::ConstPtr description;
  Config::ConstPtr values;
  std::vector<LiveParameter> parameters;  // from both
  ros::Subscriber descriptions, updates;
};

// What the window can draw many times a second. Longer messages are no parameters of a rig.
constexpr std::size_t max_bytes = 256U << 10U;

/// @throws ros::Exception if the master does not answer
std::set<std::string> nodesIn(const std::string& space) {
  ros::master::V_TopicInfo topics;
  if (!ros::master::getTopics(topics)) throw ros::Exception("no answer of the master");
  std::set<std::string> nodes;
  for (const ros::master::TopicInfo& topic : topics) {
    const std::string node = liveNodeOf(topic.name, topic.datatype, space);
    if (!node.empty()) nodes.insert(node);
  }
  return nodes;
}

}  // namespace

struct LiveNodes::Shared : std::enable_shared_from_this<Shared> {
  mutable std::mutex mutex;
  std::map<std::string, Node> nodes;
  bool looking = false;

  void follow(const std::set<std::string>& names);
  /// Keeps each message of a topic of this node as its `member`.
  template <class Message>
  ros::Subscriber subscribe(const std::string& node, const char* topic,
                            typename Message::ConstPtr Node::*member);
};

template <class Message>
ros::Subscriber LiveNodes::Shared::subscribe(const std::string& node, const char* topic,
                                             typename Message::ConstPtr Node::*member) {
  const std::weak_ptr<Shared> weak = weak_from_this();
  return ros::NodeHandle().subscribe<Message>(
      node + topic, 1, [weak, node, member](const typename Message::ConstPtr& message) {
        const std::shared_ptr<Shared> shared = weak.lock();
        if (!shared) return;
        if (const std::size_t bytes = ros::serialization::serializationLength(*message); bytes > max_bytes) {
          ROS_WARN_THROTTLE(1.0, "live parameters of %s left out: %zu bytes, expected at most %zu",
                            node.c_str(), bytes, max_bytes);
          return;
        }
        const std::lock_guard<std::mutex> lock(shared->mutex);
        const auto found = shared->nodes.find(node);
        if (found == shared->nodes.end()) return;
        Node& mine = found->second;
        mine.*member = message;
        if (mine.description)
          mine.parameters = liveParameters(*mine.description, mine.values ? *mine.values : Config());
      });
}

// Subscribers are made and destroyed without the mutex: both wait for others, among them for callbacks.
void LiveNodes::Shared::follow(const std::set<std::string>& names) {
  std::map<std::string, Node> gone;
  std::set<std::string> fresh;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    for (const std::string& name : names)
      if (!nodes[name].updates) fresh.insert(name);
    for (auto node = nodes.begin(); node != nodes.end();) {
      const auto here = node++;
      if (names.count(here->first) == 0) gone.insert(nodes.extract(here));
    }
  }
  for (const std::string& name : fresh) {
    const ros::Subscriber descriptions =
        subscribe<ConfigDescription>(name, live_descriptions, &Node::description);
    const ros::Subscriber updates = subscribe<Config>(name, live_updates, &Node::values);
    const std::lock_guard<std::mutex> lock(mutex);
    nodes[name].descriptions = descriptions;
    nodes[name].updates = updates;
  }
}

LiveNodes::LiveNodes() : shared_(std::make_shared<Shared>()) {}

void LiveNodes::look(const std::string& space) {
  {
    const std::lock_guard<std::mutex> lock(shared_->mutex);
    if (shared_->looking) return;
    shared_->looking = true;
  }
  std::thread([shared = shared_, space] {
    try {
      shared->follow(nodesIn(space));
    } catch (const std::exception&) {
      // The next look is soon.
    }
    const std::lock_guard<std::mutex> lock(shared->mutex);
    shared->looking = false;
  }).detach();
}

std::map<std::string, std::vector<LiveParameter>> LiveNodes::parameters() const {
  std::map<std::string, std::vector<LiveParameter>> all;
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  for (const auto& [name, node] : shared_->nodes)
    if (node.description) all[name] = node.parameters;
  return all;
}

}  // namespace tactile_clay::rviz_plugins
