#pragma once

#include <string>

namespace tactile_clay::device {

/// Computes the age of stamped messages. The age is known only for stamps of this computer's clock. Stamps of
/// another host whose clock differs, and stamps of a played recording, run as fast as this clock but have an
/// offset. Which of the two they are is decided by the size of the offset and by the node that publishes.
class StampCheck {
 public:
  enum class Mode {
    off,   // all messages count as new
    on,    // the stamps are of this clock
    found  // the stamps may also be of a recording; the check finds out
  };

  struct Age {
    double age = 0.0;    // s; 0 for stamps of a recording, and with Mode::off
    std::string clocks;  // what is wrong with the clocks, as the end of a line; empty: nothing
  };

  /// @param timeout s; a stamp that is further than this from the clock, behind or ahead, is stale
  StampCheck(Mode mode, double timeout) : mode_(mode), timeout_(timeout) {}

  /// To be called for each stamp, in the order in which they come.
  /// @param behind s, by how much the stamp is behind this computer's clock
  /// @param played whether a program that plays recordings sends it
  Age operator()(double behind, bool played = false);

  /// To be called if another node starts to publish.
  void restart();

  Mode mode() const { return mode_; }

  /// Whether the last stamp counted as one of a recording.
  bool ofRecording() const { return recording_; }

 private:
  Mode mode_;
  double timeout_;
  bool live_ = false;  // whether a stamp was of this clock since restart()
  bool recording_ = false;
  unsigned late_ = 0;     // number of stale stamps in a row
  double nearest_ = 0.0;  // s, of these the offset with the smallest magnitude
};

}  // namespace tactile_clay::device
