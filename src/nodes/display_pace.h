#pragma once

#include <ros/time.h>

namespace tactile_clay::nodes {

/// Holds back work that only serves displays: it takes at most a quarter of the time. On a computer that is
/// busy the work takes longer, so there is less of it, and more time is left to those who draw the results.
class DisplayPace {
 public:
  bool isDue(const ros::SteadyTime& now) const { return now >= next_; }

  /// To be called with the beginning and the end of the work.
  void worked(const ros::SteadyTime& start, const ros::SteadyTime& end) {
    next_ = end + ros::WallDuration(rest_per_work * (end - start).toSec());
  }

 private:
  static constexpr double rest_per_work = 3.0;

  ros::SteadyTime next_;
};

}  // namespace tactile_clay::nodes
