#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactile_clay::clay {

/// How much time each frame of a live simulation gets, so that simulated time follows the wall clock, and
/// frames are even and short: as many whole steps as usual, and a quarter of a period more or less where
/// simulated time is off by one and a half of that. More also needs a computer that is faster than the clock.
class LivePace {
 public:
  /// @param period s, of frames
  /// @param step s, of the simulation
  LivePace(double period, double step)
      : period_(period),
        step_(step),
        quarter_(step * std::max(std::round(0.25 * period / step), 1.0)),
        usual_(period) {}

  /// Time that the next frame is to simulate, s.
  /// @param elapsed s since the frame before it began
  double next(double elapsed) {
    usual_ += adaption * (std::min(elapsed, 2.0 * period_) - usual_);
    owed_ += elapsed;
    const double usual = step_ * std::round(std::min(usual_, period_) / step_);
    const double late = owed_ - usual, enough = 1.5 * quarter_;
    const bool has_room = pace_ >= room || usual == 0.0;
    double duration = usual;
    if (late > enough && has_room)
      duration += quarter_;
    else if (late < -enough)
      duration = std::max(usual - quarter_, 0.0);
    owed_ -= duration;
    const double beyond = std::max(owed_ - max_owed, 0.0);
    owed_ -= beyond;
    dropped_ += beyond;
    return duration;
  }

  /// To be called after a frame.
  /// @param duration s, that it simulated
  /// @param computing s, that this took
  void took(double duration, double computing) {
    if (duration > 0.0 && computing > 0.0) pace_ = duration / computing;
  }

  /// s, that will never be simulated, since the last call.
  double takeDropped() { return std::exchange(dropped_, 0.0); }

 private:
  static constexpr double adaption = 0.1;  // of the usual time between frames to each
  // Pace that a longer frame needs. Above 1 it gains time, though it may take more than a period; a tenth is
  // what paces differ from frame to frame.
  static constexpr double room = 1.1;
  static constexpr double max_owed = 0.1;  // s

  double period_, step_;
  double quarter_;     // s, of a period, in whole steps
  double usual_;       // s, between two frames
  double pace_ = 1.0;  // simulated over computing time of the last frame
  double owed_ = 0.0, dropped_ = 0.0;
};

}  // namespace tactile_clay::clay
