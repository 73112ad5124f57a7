#pragma once

namespace tactile_clay::clay {

/// Tells when frames have taken longer than they may for a while, and not just now and then: most of those of
/// two seconds. What it is told are times; it reads no clock.
class LateWatch {
 public:
  /// @param target s, that computing a period may take
  /// @param period s, of frames
  LateWatch(double target, double period) : target_(target), period_(period) {}

  /// To be called after each frame.
  /// @param elapsed s since the one before
  /// @param simulated s, of the frame
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
  double time_ = 0.0;  // s, of the window
  int frames_ = 0, slow_ = 0;
};

}  // namespace tactile_clay::clay
