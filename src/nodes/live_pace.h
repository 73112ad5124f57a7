#pragma once

#include <algorithm>
#include <utility>

namespace tactile_clay::nodes {

/// How much time each frame of a live simulation gets, so that simulated time follows the wall clock and
/// frames stay short: usually a period, and what time is owed from late frames as far as computing has room
/// for it.
class LivePace {
 public:
  /// \param period s, of frames
  explicit LivePace(double period) : period_(period) {}

  /// Time that the next frame is to simulate, s. \param elapsed s since the frame before it began
  double next(double elapsed) {
    owed_ += elapsed;
    const double most = std::clamp(period_ * pace_, period_, longest_frame * period_);
    const double duration = std::min(owed_, most);
    owed_ -= duration;
    const double beyond = std::max(owed_ - most_owed, 0.0);
    owed_ -= beyond;
    dropped_ += beyond;
    return duration;
  }

  /// To be called after a frame. \param duration s, that it simulated \param computing s, that this took
  void took(double duration, double computing) {
    if (duration > 0.0 && computing > 0.0) pace_ = duration / computing;
  }

  /// s, that will never be simulated, since the last call.
  double takeDropped() { return std::exchange(dropped_, 0.0); }

 private:
  static constexpr double longest_frame = 1.5;  // periods
  static constexpr double most_owed = 0.1;      // s

  double period_;
  double pace_ = 1.0;  // simulated over computing time of the last frame
  double owed_ = 0.0, dropped_ = 0.0;
};

}  // namespace tactile_clay::nodes
