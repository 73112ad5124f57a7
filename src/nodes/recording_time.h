#pragma once

#include <chrono>

namespace tactile_clay::nodes {

/// Makes the stamps of a source strictly increase. A stamp that is zero or not later than the one before (a
/// tracker that was restarted, a recording that loops) goes on from the one before by the last good interval,
/// and so do all after it.
class RecordingTime {
 public:
  std::chrono::nanoseconds operator()(std::chrono::nanoseconds stamp) {
    if (!started_) {
      started_ = true;
      if (stamp.count() <= 0) repair(stamp, interval_);
    } else if (stamp + shift_ <= last_) {
      repair(stamp, last_ + interval_);
    } else if (stamp.count() <= 0) {
      repair(stamp, last_ + interval_);
    } else if (stamp + shift_ - last_ < longest_interval) {
      interval_ = stamp + shift_ - last_;
    }
    return last_ = stamp + shift_;
  }

  /// How often a stamp did not follow the one before.
  unsigned repaired() const { return repaired_; }

 private:
  void repair(std::chrono::nanoseconds stamp, std::chrono::nanoseconds to) {
    shift_ = to - stamp;
    ++repaired_;
  }

  static constexpr std::chrono::nanoseconds longest_interval = std::chrono::milliseconds(100);
  bool started_ = false;
  unsigned repaired_ = 0;
  std::chrono::nanoseconds shift_{0}, last_{0}, interval_{1'000'000'000 / 60};
};

}  // namespace tactile_clay::nodes
