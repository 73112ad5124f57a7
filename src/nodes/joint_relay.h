#pragma once

#include <ros/ros.h>
#include <sensor_msgs/JointState.h>

#include <map>
#include <string>

#include "nodes/inbox.h"

namespace tactile_clay::nodes {

/// @param joints position of each by its name, rad or m
sensor_msgs::JointState jointState(const std::map<std::string, double>& joints, ros::Time stamp);

/// Passes the joint states of a topic on to `TOPIC_checked`, where robot_state_publisher listens: a stamp
/// near the end of 32 bits ends that, and one of the future stops it for good. What is passed on has a stamp
/// that is not of the future, and as many names as positions, all finite.
class JointRelay {
 public:
  JointRelay(ros::NodeHandle nh, Inbox& inbox, const std::string& topic);

 private:
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
};

}  // namespace tactile_clay::nodes
