#pragma once

namespace tactile_clay::clay {

/// Detects that frames have taken too long for a while, and not only now and then: in two seconds, more than
/// half of the frames. All times are passed to it; it reads no clock.
class LateWatch {
 public:
  /// @param target s, maximum time for computing one period
  /// @param period s, of frames
  LateWatch(double target, double period) : target_(target), period_(period) {}

  /// To be called after each frame.
  /// @param elapsed s since the frame before
  /// @param simulated s, that the frame simulated
  /// @param computing s, that this took
  /// @return whether it is time to give up accuracy
  bool late(double elapsed, double simulated, double computing) {
    time_ += elapsed;
    if (simulated > 0.0) {
      ++frames_;
      if (computing * period_ > target_ * simulated) ++slow_;
    }
    if (time_ < window) return false;
    const bool late = 2 * slow_ > frames_;
    time_ = 0.0;
    frames_ = slow_ = 0;
    return late;
  }

 private:
  static constexpr double window = 2.0;  // s

  double target_, period_;
  double time_ = 0.0;  // s, elapsed in the window
  int frames_ = 0, slow_ = 0;
};

}  // namespace tactile_clay::clay
