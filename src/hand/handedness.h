#pragma once

#include <string>

#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// Whether palm and knuckles lie before the wrist, the knuckles in their order, and the palm's +Y, and the
/// side to which fingers bend, are those of a hand of its side.
/// @param hand with palm, wrist and three fingers at least, in which all places are a hand's
/// @param scale of it
/// @return empty if so, else one line
std::string faultOfSide(const TrackedHand& hand, double scale);

}  // namespace tactile_clay::hand
