#pragma once

#include <cstddef>
#include <vector>

#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// Leaves the more confident of two hands of one side (the first of equals); keeps the order.
/// @return how many were removed
std::size_t keepOneHandASide(std::vector<TrackedHand>& hands);

/// One hand a side, the left one first.
/// @throws std::invalid_argument with the line of `faultOfNumbers` where a hand has one
std::vector<TrackedHand> leftThenRight(std::vector<TrackedHand> hands);

}  // namespace tactile_clay::hand
