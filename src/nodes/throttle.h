#pragma once

#include <ros/time.h>

#include <optional>
#include <string>
#include <utility>

namespace tactile_clay::nodes {

/// Lets one line pass per period at most, by a clock that simulated time does not stop.
class Throttle {
 public:
  explicit Throttle(double period = 5.0) : period_(period) {}  // s

  /// Whether a line may be logged now.
  /// @return if so, how many lines were held back since the last one; else nothing
  std::optional<unsigned> pass() {
    const ros::SteadyTime now = ros::SteadyTime::now();
    if (!last_.isZero() && (now - last_).toSec() < period_) {
      ++held_;
      return std::nullopt;
    }
    last_ = now;
    return std::exchange(held_, 0U);
  }

 private:
  double period_;
  ros::SteadyTime last_;
  unsigned held_ = 0;
};

/// The text " (and N before it)", or an empty text.
inline std::string andMore(unsigned held) {
  return held == 0 ? "" : " (and " + std::to_string(held) + " before it)";
}

}  // namespace tactile_clay::nodes
