#pragma once

#include <ros/ros.h>

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>

namespace tactile_clay::nodes {

/// Waits for the answer to a tracker sample: a message with the stamp of the sample that caused it.
class Answers {
 public:
  /// A message with this stamp came. May be called from any thread.
  void add(ros::Time stamp);

  /// Waits for an answer whose stamp is `stamp` or at most 1 s later. The wait is measured by the wall clock.
  /// @return false if `patience` or `give_up` ended the wait
  bool wait(ros::Time stamp, ros::WallDuration patience, const std::function<bool()>& give_up);

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<ros::Time> answered_;  // the newest stamps
};

}  // namespace tactile_clay::nodes
