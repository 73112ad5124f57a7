#pragma once

#include <algorithm>
#include <chrono>

#include "nodes/stamps.h"

namespace tactile_clay::nodes {

/// Makes the stamps of a source strictly increase, and keeps them in the range for computations. A stamp is
/// repaired if it is zero, not later than the one before (a tracker that was restarted, a recording that
/// loops), or more than an hour later than it. A repaired stamp is the one before plus the last good
/// interval, and all stamps after it are shifted by as much.
class RecordingTime {
 public:
  std::chrono::nanoseconds operator()(std::chrono::nanoseconds stamp) {
    // No sum below wraps around: the stamp and the shift are both less than half of the range of 64 bits.
    stamp = std::clamp<std::chrono::nanoseconds>(stamp, std::chrono::nanoseconds(0), stamp_end);
    if (!started_) {
      started_ = true;
      if (stamp.count() <= 0 || stamp > latest_start) repair(stamp, interval_);
    } else if (stamp.count() <= 0 || stamp + shift_ <= last_ || stamp + shift_ - last_ > longest_pause) {
      repair(stamp, last_ + interval_);
    } else if (stamp + shift_ - last_ < longest_interval) {
      interval_ = stamp + shift_ - last_;
    }
    return last_ = stamp + shift_;
  }

  /// Number of stamps that did not follow the one before.
  unsigned repaired() const { return repaired_; }

 private:
  void repair(std::chrono::nanoseconds stamp, std::chrono::nanoseconds to) {
    shift_ = to - stamp;
    ++repaired_;
  }

  static constexpr std::chrono::nanoseconds longest_interval = std::chrono::milliseconds(100);
  static constexpr std::chrono::nanoseconds longest_pause = std::chrono::hours(1);
  // Leaves a recording one year until the end of stamps.
  static constexpr std::chrono::nanoseconds latest_start = stamp_end - std::chrono::hours(24 * 365);
  bool started_ = false;
  unsigned repaired_ = 0;
  std::chrono::nanoseconds shift_{0}, last_{0}, interval_{1'000'000'000 / 60};
};

}  // namespace tactile_clay::nodes
