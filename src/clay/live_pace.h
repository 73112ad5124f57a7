#pragma once

#include <algorithm>
#include <cmath>

#include "clay/clay.h"

namespace tactile_clay::clay {

/// What a frame of a live simulation is to do.
struct LiveFrame {
  double duration = 0.0;     // s, of simulated time
  double step_factor = 1.0;  // 1 to `largest_step_factor`: how many times longer than usual its steps are
  double dropped = 0.0;      // s before it that will never be simulated
};

/// How much time each frame of a live simulation gets, so that simulated time follows the wall clock, and
/// frames are even and short: as many steps as usual, and a quarter of a period more or less where simulated
/// time is off by one and a half of that. More also needs a computer that is faster than the clock.
class LivePace {
 public:
  /// \param period s, of frames \param step s, of the simulation
  LivePace(double period, double step)
      : period_(period),
        step_(step),
        quarter_(std::max(std::round(0.25 * period / step), 1.0)),
        usual_(period) {}

  /// \param elapsed s since the frame before it began
  LiveFrame next(double elapsed) {
    usual_ += adaption * (std::min(elapsed, 2.0 * period_) - usual_);
    owed_ += elapsed;
    const double usual = std::round(std::min(usual_, period_) / step_);
    steps_ = usual;
    const double late = owed_ - usual * step_, enough = 1.5 * quarter_ * step_;
    const bool has_room = pace_ >= room || usual == 0.0;
    if (late > enough && has_room)
      steps_ = usual + quarter_;
    else if (late < -enough)
      steps_ = std::max(usual - quarter_, 0.0);
    const double duration = steps_ * step_;
    owed_ -= duration;
    const double dropped = std::max(owed_ - most_owed, 0.0);
    owed_ -= dropped;
    return {duration, 1.0, dropped};
  }

  /// To be called after a frame. \param computing s, that it took
  void took(double computing) {
    if (steps_ > 0.0 && computing > 0.0) pace_ = steps_ * step_ / computing;
  }

 private:
  static constexpr double adaption = 0.1;  // of the usual time between frames to each
  // Pace that more steps need. Above 1 they gain time, though they may take more than a period; a tenth is
  // what paces differ from frame to frame.
  static constexpr double room = 1.1;
  static constexpr double most_owed = 0.1;  // s

  double period_, step_;
  double quarter_;      // steps, of a period
  double usual_;        // s, between two frames
  double steps_ = 0.0;  // of the last frame
  double pace_ = room;  // time that its steps usually stand for, over its computing time
  double owed_ = 0.0;   // s, not simulated yet
};

}  // namespace tactile_clay::clay
