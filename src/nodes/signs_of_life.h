#pragma once

#include <ros/ros.h>

#include <string>

#include "nodes/kept.h"

namespace tactile_clay::nodes {

constexpr double sign_of_life_period = 0.2;  // s
// s, shorter than the patience of keep_running, so that the log has the name of the silent node before the
// process is ended.
constexpr double silence_to_tell = 2.0;

/// Gives signs of life of a node, from the thread that serves its callbacks, while this object lives.
class SignsOfLife {
 public:
  /// @param nh handle of the queue with the callbacks
  /// @param node its full name
  SignsOfLife(const ros::NodeHandle& nh, const std::string& node)
      : node_(node),
        timer_(nh.createWallTimer(ros::WallDuration(sign_of_life_period), [node](const ros::WallTimerEvent&) {
          beat(node);
          const std::string silent = silentFor(silence_to_tell);
          if (!silent.empty())
            ROS_WARN_THROTTLE(5.0, "no sign of life for %.0f s from %s", silence_to_tell, silent.c_str());
        })) {}
  ~SignsOfLife() {
    timer_.stop();
    endOfLife(node_);
  }
  SignsOfLife(const SignsOfLife&) = delete;
  SignsOfLife& operator=(const SignsOfLife&) = delete;

 private:
  std::string node_;
  ros::WallTimer timer_;
};

}  // namespace tactile_clay::nodes
