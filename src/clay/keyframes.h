#pragma once

#include <cstddef>
#include <deque>

#include "clay/sculpture.h"

namespace tactile_clay::clay {

/// States of the clay in the past, a second of simulated time apart, to go back to. The oldest are forgotten
/// where they are too old, or take too much memory.
class Keyframes {
 public:
  struct Limits {
    double seconds = 120.0;                // simulated, of which states are kept; 0: none are
    std::size_t bytes = 256u * (1 << 20);  // that all states take together
  };
  struct State {
    double time = 0.0;  // s, of the clock of the Keyframes
    int version = 0;    // that the caller gave it
    Sculpture clay;
  };

  explicit Keyframes(Limits limits) : limits_(limits) {}

  /// Tells that the clay went on by `duration` s.
  /// @return whether its state is to be kept now
  bool pass(double duration);
  void keep(Sculpture clay, int version);

  /// Goes back to the newest state that is at least `seconds` old, and forgets those after it.
  /// @param[out] went_back s
  /// @throws std::runtime_error with one line where no state is that old
  const State& back(double seconds, double& went_back);

  std::size_t bytes() const { return bytes_; }
  std::size_t size() const { return states_.size(); }

 private:
  void forgetOldest();

  Limits limits_;
  std::deque<State> states_;  // by ascending time
  double now_ = 0.0;          // s
  std::size_t bytes_ = 0;
};

}  // namespace tactile_clay::clay
