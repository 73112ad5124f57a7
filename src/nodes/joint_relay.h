#pragma once

#include <ros/ros.h>
#include <sensor_msgs/JointState.h>

#include <map>
#include <string>

#include "nodes/inbox.h"

namespace tactile_clay::nodes {

/// @param joints position of each joint by its name, rad or m
sensor_msgs::JointState jointState(const std::map<std::string, double>& joints, ros::Time stamp);

/// Passes the joint states of a topic on to `TOPIC_checked`, to which robot_state_publisher subscribes: a
/// stamp near the end of 32 bits would end robot_state_publisher, and a stamp of the future would stop it for
/// good. A joint state is passed on only if its stamp is not of the future, and if it has as many positions
/// as names, all finite.
class JointRelay {
 public:
  JointRelay(ros::NodeHandle nh, Inbox& inbox, const std::string& topic);

 private:
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
};

}  // namespace tactile_clay::nodes
