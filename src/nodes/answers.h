#pragma once

#include <ros/ros.h>

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>

namespace tactile_clay::nodes {

/// Waits for what comes back: a message with the stamp of the sample that caused it.
class Answers {
 public:
  /// A message with this stamp came. May be called from any thread.
  void add(ros::Time stamp);

  /// Waits until the sample `stamp`, or one of the second after it, was answered, by the wall clock.
  /// @return false if `patience` or `give_up` ended the wait
  bool wait(ros::Time stamp, ros::WallDuration patience, const std::function<bool()>& give_up);

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<ros::Time> answered_;  // the newest
};

}  // namespace tactile_clay::nodes
