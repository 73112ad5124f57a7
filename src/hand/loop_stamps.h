#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace tactile_clay::hand {

/// Stamps of a recording that starts again at its end: each pass goes on a mean interval after the one
/// before.
class LoopStamps {
 public:
  using Time = std::chrono::nanoseconds;

  /// The stamp of the next frame.
  /// @param recorded what the recording says
  Time operator()(Time recorded) {
    recorded = std::clamp(recorded, Time(0), Time(latest));
    if (frames_++ == 0) first_ = recorded;
    last_ = recorded;
    return recorded + offset_;
  }

  /// The recording starts again.
  void rewind() {
    using namespace std::chrono_literals;
    const Time period = frames_ > 1 ? (last_ - first_) / (frames_ - 1) : 16'666'667ns;
    // A pass that takes a year, by what its frames say, does not count: sums would wrap around.
    const Time pass = last_ - first_ + std::max<Time>(period, 1us);
    offset_ = std::clamp(offset_ + (pass < longest_pass ? pass : period), Time(0), Time(latest));
    frames_ = 0;
  }

 private:
  static constexpr Time latest = std::chrono::hours(24 * 365 * 100);
  static constexpr Time longest_pass = std::chrono::hours(24 * 365);

  Time offset_{0};           // of this pass
  Time first_{0}, last_{0};  // of this pass, as recorded
  std::int64_t frames_ = 0;  // of this pass
};

}  // namespace tactile_clay::hand
