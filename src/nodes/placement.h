#pragma once

#include <chrono>
#include <string>

#include "hand/hand_check.h"
#include "hand/tracked_hand.h"
#include "nodes/transforms.h"
#include "safety/silence_times.h"

namespace tactile_clay::nodes {

/// Logs what was left out of a frame, at most one line per second.
void tell(const hand::LeftOut& left_out);

/// Judges the hands of a frame (hand_check.h), removes those that are wrong, and logs this.
hand::LeftOut leaveOutBadHands(hand::TrackedFrame& frame);

/// Time for which a repeated live hand stays if no hand_cleaner bridges it: longer than the 50 ms between two
/// samples of a slow tracker, short enough for the array to be silent after 150 ms.
inline constexpr std::chrono::milliseconds repeats_patience = silence_times::hand_repeated;

/// Moves all hands of a frame into `world`; hands that tf2 cannot place are removed.
void placeInWorld(hand::TrackedFrame& frame, const std::string& world, Transforms& transforms);

}  // namespace tactile_clay::nodes
