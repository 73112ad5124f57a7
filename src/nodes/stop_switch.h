#pragma once

#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/spinner.h>
#include <std_msgs/Empty.h>
#include <std_srvs/Trigger.h>

#include <functional>
#include <string>
#include <vector>

namespace tactile_clay::nodes {

/// The emergency stop of an array, by the same names for every one: `array/stop` and `array/reset`, each a
/// service (std_srvs/Trigger) and a topic (std_msgs/Empty), and the services `~stop` and `~reset`, for one of
/// several arrays. It has a queue and a thread of its own, so that no busy callback delays it. A stop
/// outlives the program: where `keep_running` starts it again, it begins stopped.
class StopSwitch {
 public:
  /// Stops where the node was stopped before it was started again. Starts to listen.
  /// @param stop, reset are called by the switch's thread, one at a time. They return what to answer, and
  /// must not throw
  StopSwitch(ros::NodeHandle nh, ros::NodeHandle private_nh, std::function<std::string()> stop,
             std::function<std::string()> reset);

 private:
  void serve(ros::NodeHandle nh, const std::string& name, const std::function<std::string()>& action);
  void listen(ros::NodeHandle nh, const std::string& name, const std::function<std::string()>& action);

  ros::CallbackQueue queue_;
  std::vector<ros::ServiceServer> servers_;
  std::vector<ros::Subscriber> subscribers_;
  ros::AsyncSpinner spinner_;  // goes first
};

}  // namespace tactile_clay::nodes
