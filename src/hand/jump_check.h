#pragma once

#include <chrono>
#include <vector>

#include "hand/hand_check.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// Whether a palm that is at `to` was not at `from` `dt` s before: no hand goes farther than 0.05 m at more
/// than 20 m/s.
bool palmJumps(const TrackedHand& from, const TrackedHand& to, double dt);

/// Leaves out hands that jump: a hand that is suddenly elsewhere is there from its second sample on, as
/// another hand, and one that jumps to and fro is nowhere.
class JumpCheck {
 public:
  /// Of hands at a time that does not go back.
  LeftOut leaveOutJumps(std::vector<TrackedHand>& hands, std::chrono::nanoseconds stamp);

 private:
  std::vector<TrackedHand> last_;  // as they came
  std::chrono::nanoseconds stamp_{0};
};

}  // namespace tactile_clay::hand
