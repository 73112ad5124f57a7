#include "nodes/joint_relay.h"

#include <sensor_msgs/JointState.h>

#include <cmath>
#include <stdexcept>
#include <utility>

namespace tactile_clay::nodes {
namespace {

constexpr std::size_t max_joints = 1000;

}  // namespace

sensor_msgs::JointState ofJoints(const sensor_msgs::JointState& state, const std::set<std::string>& joints,
                                 ros::Time now) {
  const std::size_t count = state.name.size();
  if (count > max_joints || state.position.size() != count)
    throw std::runtime_error(std::to_string(count) + " joints with " + std::to_string(state.position.size()) +
                             " positions, expected as many, at most " + std::to_string(max_joints));
  if (isOfTheFuture(state.header.stamp, now))
    throw std::runtime_error("stamp in the future, " + std::to_string(state.header.stamp.sec) +
                             " s, expected one in the past");
  sensor_msgs::JointState known;
  known.header = state.header;
  for (std::size_t i = 0; i < count; ++i) {
    if (joints.count(state.name[i]) == 0) continue;
    if (!std::isfinite(state.position[i]))
      throw std::runtime_error("joint '" + state.name[i] +
                               "' at a position that is not finite, expected a number");
    known.name.push_back(state.name[i]);
    known.position.push_back(state.position[i]);
    if (state.velocity.size() == count) known.velocity.push_back(state.velocity[i]);
    if (state.effort.size() == count) known.effort.push_back(state.effort[i]);
  }
  return known;
}

sensor_msgs::JointState jointState(const std::map<std::string, double>& joints, ros::Time stamp) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  for (const auto& [name, position] : joints) {
    message.name.push_back(name);
    message.position.push_back(position);
  }
  return message;
}

JointRelay::JointRelay(ros::NodeHandle nh, Inbox& inbox, const std::string& topic,
                       std::set<std::string> joints)
    : joints_(std::move(joints)),
      publisher_(nh.advertise<sensor_msgs::JointState>(topic + "_checked", 10)),
      subscriber_(inbox.subscribe<sensor_msgs::JointState>(
          nh, topic, 10, [this](const sensor_msgs::JointState::ConstPtr& state) {
            const sensor_msgs::JointState known = ofJoints(*state, joints_, ros::Time::now());
            if (!known.name.empty()) publisher_.publish(known);
          })) {}

}  // namespace tactile_clay::nodes
