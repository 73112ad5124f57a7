#pragma once

#include <chrono>
#include <string>

#include "hand/hand_check.h"
#include "hand/tracked_hand.h"
#include "nodes/transforms.h"
#include "safety/silence_times.h"

namespace tactile_clay::nodes {

/// Tells of what was left out of a frame, one line a second.
void tell(const hand::LeftOut& left_out);

/// Judges the hands of a frame (hand_check.h) and removes those that are none; tells of it.
hand::LeftOut leaveOutBadHands(hand::TrackedFrame& frame);

/// For which a live hand that is only repeated stays where no hand_cleaner bridges it: longer than the 50 ms
/// between two samples of a slow tracker, short enough for the array to be silent after 150 ms.
inline constexpr std::chrono::milliseconds repeats_patience = silence_times::hand_repeated;

/// Whether a message on a topic is live: a played one has the stamps of its recording, or simulated time.
bool freshStamp(std::chrono::nanoseconds stamp);

/// Moves all hands of a frame into `world`; hands that tf2 cannot place are removed.
void placeInWorld(hand::TrackedFrame& frame, const std::string& world, Transforms& transforms);

}  // namespace tactile_clay::nodes
