#pragma once

#include <string>
#include <vector>

#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// What is wrong with a hand, in one line, or empty: it must be a left or a right one, positions must be
/// finite and within 10 m, orientations normalisable, radii 0 to 0.1 m, bones and the distance of palm and
/// wrist at most 0.2 m, confidence 0 to 1.
std::string faultOf(const TrackedHand& hand);

/// Leaves the more confident of two hands of one side (the first of equals); keeps the order.
/// \return how many were removed
std::size_t keepOneHandASide(std::vector<TrackedHand>& hands);

}  // namespace tactile_clay::hand
