#pragma once

#include <array>
#include <chrono>
#include <deque>
#include <vector>

#include "hand/hand_check.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// Leaves out hands that a live tracker only repeats. A live hand trembles and its tracker has noise, so no
/// two samples of it have the same bits in all joints. If a sample has those of one of the last eight, the
/// tracker has seen nothing new, whatever its clock, ids and confidence are, and the hand counts as not seen.
/// Recordings and scripted hands may stand still, so this check is not for them.
class RepeatedHands {
 public:
  using Time = std::chrono::nanoseconds;

  /// @param patience time for which a repeated hand stays. Some drivers send each sample twice. Without
  /// hand_cleaner.h, which bridges missing samples, their hands would flicker
  explicit RepeatedHands(Time patience) : patience_(patience) {}

  /// @param now when the hands came, by a clock that never goes back
  /// @return its lines name hands that stood still for 50 ms
  LeftOut leaveOutRepeats(std::vector<TrackedHand>& hands, Time now);

 private:
  struct Sample {
    TrackedHand hand;
    Time since;  // when it came first
  };

  Time patience_;
  std::array<std::deque<Sample>, 2> last_;  // by side, the newest at the end
};

}  // namespace tactile_clay::hand
