#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hand/choreography.h"

namespace tactile_clay::hand {

/// A tracker with mishaps, which sees the hands of a score. Times between mishaps are exponentially
/// distributed, for each hand separately.
struct TrackerScript {
  Score score;
  double rate = 110.0;              // Hz
  double sight = 0.3;               // m; a hand whose palm has |x| or |y| above this is not seen
  double dropout_interval = 0.0;    // s, mean time between two dropouts; 0: none
  double dropout_duration = 0.03;   // s, mean; the hand comes back under another id
  double id_change_interval = 0.0;  // s, mean time between two changes of id alone; 0: none
  std::uint32_t seed = 1;           // of the mishaps, and of the noise
};

constexpr double longest_score = 7200.0;  // s

/// A tracker that sees scripted hands, with noise, dropouts and changes of id. The same script gives the same
/// frames.
class ScriptedTracker {
 public:
  /// @throws std::invalid_argument with one line if a number is out of its range
  explicit ScriptedTracker(TrackerScript script);

  std::uint64_t frames() const { return frames_; }

  /// Frame `i` in the coordinate frame `world`, stamped (i + 1) / rate.
  TrackedFrame frame(std::uint64_t i) const;

 private:
  struct Dropout {
    double begin, end;  // s
  };
  struct Mishaps {
    std::vector<Dropout> dropouts;
    std::vector<double> id_changes;  // s, increasing; also at the end of each dropout
  };

  TrackerScript script_;
  std::uint64_t frames_;
  std::array<Mishaps, 2> mishaps_;  // by side
};

}  // namespace tactile_clay::hand
