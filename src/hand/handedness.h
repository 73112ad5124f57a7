#pragma once

#include <string>

#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// Checks the side of a hand. Palm and knuckles are on the same side of the wrist, and the knuckles are in
/// order. The palm's +Y, and the side to which fingers bend, are those of a hand of its side.
/// @param hand with palm, wrist and at least three fingers, whose places are all those of a hand
/// @param scale size of the hand
/// @return empty if all is right, else one line
std::string faultOfSide(const TrackedHand& hand, double scale);

}  // namespace tactile_clay::hand
