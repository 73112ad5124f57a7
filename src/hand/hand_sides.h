#pragma once

#include <cstddef>
#include <vector>

#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// Keeps only the more confident of two hands of one side (the first of equals), in the same order.
/// @return number of removed hands
std::size_t keepOneHandASide(std::vector<TrackedHand>& hands);

/// One hand per side, the left one first.
/// @throws std::invalid_argument with the line of `faultOfNumbers` if a hand has such a fault
std::vector<TrackedHand> leftThenRight(std::vector<TrackedHand> hands);

}  // namespace tactile_clay::hand
