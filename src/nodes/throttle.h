#pragma once

#include <ros/time.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

namespace tactile_clay::nodes {

/// Lets a line pass at most once in a while, by a clock that simulated time does not stop.
class Throttle {
 public:
  explicit Throttle(double period = 5.0) : period_(period) {}  // s

  /// Whether a line may be told now.
  /// @return how many were held back since the one before, or nothing
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

/// " (and N before)", or nothing.
inline std::string andMore(unsigned held) {
  return held == 0 ? "" : " (and " + std::to_string(held) + " before it)";
}

/// A text of the outside world as one line of printable characters and ordinary length.
inline std::string printableLine(std::string text) {
  constexpr std::size_t longest = 400;
  const bool cut = text.size() > longest;
  if (cut) text.resize(longest);
  // Bytes from 128 on are letters of UTF-8.
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return cut ? text + "..." : text;
}

}  // namespace tactile_clay::nodes
