#pragma once

#include <cstddef>
#include <deque>

#include "clay/sculpture.h"

namespace tactile_clay::clay {

/// Past states of the clay, one second of simulated time apart, to go back to. The oldest states are
/// forgotten if they are too old, or if all states take too much memory.
class Keyframes {
 public:
  struct Limits {
    double seconds = 120.0;  // simulated time from which states are kept; 0: none are kept
    std::size_t bytes = std::size_t{256} << 20;  // maximum of all states together
  };
  struct State {
    double time = 0.0;  // s, of the clock of the Keyframes
    int version = 0;    // given by the caller
    Sculpture clay;
  };

  explicit Keyframes(Limits limits) : limits_(limits) {}

  /// To be called when the clay has advanced by `duration` s.
  /// @return whether its state is to be kept now
  bool pass(double duration);
  void keep(const Sculpture& clay, int version);

  /// Goes back to the newest state that is at least `seconds` old, and forgets the states after it.
  /// @param[out] went_back s, the age of that state
  /// @throws std::runtime_error with one line if no state is that old
  const State& back(double seconds, double& went_back);

  std::size_t bytes() const { return bytes_; }
  std::size_t size() const { return states_.size(); }

 private:
  bool isTooOld() const;  // the oldest state, if a new one comes
  State takeOldest();

  Limits limits_;
  std::deque<State> states_;  // by ascending time
  double now_ = 0.0;          // s
  std::size_t bytes_ = 0;
};

}  // namespace tactile_clay::clay
