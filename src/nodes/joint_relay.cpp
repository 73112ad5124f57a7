#include "nodes/joint_relay.h"

#include <sensor_msgs/JointState.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tactile_clay::nodes {
namespace {

constexpr std::size_t max_joints = 1000;

void requireSane(const sensor_msgs::JointState& state) {
  const std::size_t count = state.name.size();
  if (count > max_joints || state.position.size() != count)
    throw std::runtime_error(std::to_string(count) + " joints with " + std::to_string(state.position.size()) +
                             " positions, expected as many, at most " + std::to_string(max_joints));
  for (std::size_t i = 0; i < count; ++i) {
    if (state.name[i].size() > max_frame_id)
      throw std::runtime_error("joint with a name of more than 256 characters");
    if (!std::isfinite(state.position[i]))
      throw std::runtime_error("joint '" + state.name[i] +
                               "' at a position that is not finite, expected a number");
  }
  if (isOfTheFuture(state.header.stamp, ros::Time::now()))
    throw std::runtime_error("stamp in the future, " + std::to_string(state.header.stamp.sec) +
                             " s, expected one in the past");
}

}  // namespace

sensor_msgs::JointState jointState(const std::map<std::string, double>& joints, ros::Time stamp) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  for (const auto& [name, position] : joints) {
    message.name.push_back(name);
    message.position.push_back(position);
  }
  return message;
}

JointRelay::JointRelay(ros::NodeHandle nh, Inbox& inbox, const std::string& topic)
    : publisher_(nh.advertise<sensor_msgs::JointState>(topic + "_checked", 10)),
      subscriber_(inbox.subscribe<sensor_msgs::JointState>(
          nh, topic, 10, [this](const sensor_msgs::JointState::ConstPtr& state) {
            requireSane(*state);
            publisher_.publish(state);
          })) {}

}  // namespace tactile_clay::nodes
