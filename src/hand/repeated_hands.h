#pragma once

#include <array>
#include <chrono>
#include <optional>
#include <vector>

#include "hand/hand_check.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// Leaves out hands that a live tracker only repeats. A live hand trembles and its tracker has noise, so that
/// no two samples of it have the same bits in all of its joints: where they have, the tracker has seen
/// nothing new, whatever its clock, ids and confidence say, and its hand counts as not seen. Recordings and
/// scripted hands may hold still: this is no check for them.
class RepeatedHands {
 public:
  using Time = std::chrono::nanoseconds;

  /// @param patience for which a repeated hand stays: some drivers send each sample twice, and where nobody
  /// bridges what is not seen (hand_cleaner.h), their hands would flicker
  explicit RepeatedHands(Time patience) : patience_(patience) {}

  /// @param now when the hands came, by a clock that runs on. A line is told once a hand stood still for 50
  /// ms
  LeftOut leaveOutRepeats(std::vector<TrackedHand>& hands, Time now);

 private:
  struct Sample {
    TrackedHand hand;
    Time since;  // when it came first
  };

  Time patience_;
  std::vector<Sample> last_;
};

}  // namespace tactile_clay::hand
