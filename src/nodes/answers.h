#pragma once

#include <ros/ros.h>
#include <tactile_clay/ArrayState.h>

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>

#include "nodes/inbox.h"

namespace tactile_clay::nodes {

/// Waits for what comes back from the array: a state with the stamp of the sample that caused it.
class Answers {
 public:
  Answers(ros::NodeHandle nh, Inbox& inbox);

  /// Waits until the array has answered the sample `stamp`, or one of the second after it, by the wall clock.
  /// \return false if `patience` or `give_up` ended the wait
  bool wait(ros::Time stamp, ros::WallDuration patience, const std::function<bool()>& give_up);

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<ros::Time> answered_;  // the newest
  ros::Subscriber subscriber_;
};

}  // namespace tactile_clay::nodes
