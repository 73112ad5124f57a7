#pragma once

#include <string>

namespace tactile_clay::device {

/// How old is what comes with a stamp? Only stamps of this computer's clock can tell. Those of another host
/// whose clock is apart, and those of a recording that is played, run as fast as this clock but somewhere
/// else; which of the two they are is told by how far away they are, and by who sends them.
class StampCheck {
 public:
  enum class Mode {
    off,   // everything is new
    on,    // stamps are of this clock
    found  // they may be of a recording instead, which is found out
  };

  struct Age {
    double age = 0.0;    // s; 0 where the stamps are not of this clock
    std::string clocks;  // what is wrong with the clocks, words for the end of a line; empty: nothing
  };

  /// @param timeout s, beyond which something is stale
  StampCheck(Mode mode, double timeout) : mode_(mode), timeout_(timeout) {}

  /// To be asked of each stamp, in the order in which they come.
  /// @param behind s, by which the stamp is behind this computer's clock
  /// @param played whether a program that plays recordings sends it
  Age operator()(double behind, bool played = false);

  /// What comes next is of somebody else.
  void restart();

  Mode mode() const { return mode_; }

  /// Whether the last stamp was taken for one of a recording.
  bool ofRecording() const { return recording_; }

 private:
  Mode mode_;
  double timeout_;
  bool live_ = false;  // a stamp was of this clock since the start
  bool recording_ = false;
  unsigned late_ = 0;     // stamps in a row that were stale
  double nearest_ = 0.0;  // s, the minimum that one of these was behind
};

}  // namespace tactile_clay::device
