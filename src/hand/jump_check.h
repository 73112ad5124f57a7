#pragma once

#include <chrono>
#include <vector>

#include "hand/hand_check.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// Whether a palm jumped from `from` to `to` in `dt` s: by more than 0.05 m, at more than 20 m/s.
bool palmJumps(const TrackedHand& from, const TrackedHand& to, double dt);

/// Leaves out hands that jump. A hand that is suddenly elsewhere is there from its second sample on, as
/// another hand. A hand that jumps to and fro is left out everywhere.
class JumpCheck {
 public:
  /// Leaves out the hands of a frame that jump.
  /// @param stamp time of the frame, which does not go back
  LeftOut leaveOutJumps(std::vector<TrackedHand>& hands, std::chrono::nanoseconds stamp);

 private:
  std::vector<TrackedHand> last_;  // hands of the last frame, as they came
  std::chrono::nanoseconds stamp_{0};
};

}  // namespace tactile_clay::hand
