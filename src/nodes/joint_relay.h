#pragma once

#include <ros/ros.h>
#include <sensor_msgs/JointState.h>

#include <map>
#include <set>
#include <string>

#include "nodes/inbox.h"

namespace tactile_clay::nodes {

/// @param joints position of each joint by its name, rad or m
sensor_msgs::JointState jointState(const std::map<std::string, double>& joints, ros::Time stamp);

/// The part of a joint state that is of these joints, in its order. Velocities and efforts stay only if there
/// is one for each joint.
/// @return a state without joints if none is of these
/// @throws std::runtime_error with one line if there are not as many positions as names, a position of one of
/// the joints is not finite, or the stamp is after `now`
sensor_msgs::JointState ofJoints(const sensor_msgs::JointState& state, const std::set<std::string>& joints,
                                 ros::Time now);

/// Passes the joint states of a topic on to `TOPIC_checked`, to which robot_state_publisher subscribes: a
/// stamp near the end of 32 bits would end robot_state_publisher, a stamp in the future would stop it for
/// good, and it keeps the name of every joint for ever. So only joints of the model are passed on: others,
/// such as those of another robot, are left out of the message.
class JointRelay {
 public:
  /// @param joints names of all joints of the model that can move
  JointRelay(ros::NodeHandle nh, Inbox& inbox, const std::string& topic, std::set<std::string> joints);

 private:
  std::set<std::string> joints_;
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
};

}  // namespace tactile_clay::nodes
