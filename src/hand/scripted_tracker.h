#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hand/choreography.h"

namespace tactile_clay::hand {

/// What a tracker makes of hands that are really there. Times between mishaps are exponential, of each hand
/// by itself.
struct TrackerScript {
  Score score;
  double rate = 110.0;              // Hz
  double sight = 0.3;               // m; a hand whose palm is farther aside than this is not seen
  double dropout_interval = 0.0;    // s in the mean between two dropouts; 0: none
  double dropout_duration = 0.03;   // s in the mean; the hand comes back under another id
  double id_change_interval = 0.0;  // s in the mean between two changes of id alone; 0: none
  std::uint32_t seed = 1;           // of the mishaps, and of the noise
};

constexpr double longest_score = 7200.0;  // s

/// A tracker that sees scripted hands, with noise, dropouts and changes of id: the same for the same script.
class ScriptedTracker {
 public:
  /// @throws std::invalid_argument with one line where a number is out of its range
  explicit ScriptedTracker(TrackerScript script);

  std::uint64_t frames() const { return frames_; }

  /// Frame `i` in frame `world`, stamped (i + 1) / rate.
  TrackedFrame frame(std::uint64_t i) const;

 private:
  struct Dropout {
    double begin, end;  // s
  };
  struct Mishaps {
    std::vector<Dropout> dropouts;
    std::vector<double> id_changes;  // s, increasing, with those after dropouts
  };

  TrackerScript script_;
  std::uint64_t frames_;
  std::array<Mishaps, 2> mishaps_;  // by side
};

}  // namespace tactile_clay::hand
