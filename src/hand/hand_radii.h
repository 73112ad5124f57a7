#pragma once

#include <string>

#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// Replaces radii that are not those of a hand by those of `joint_anatomy` at the size of the hand. First all
/// radii are judged as one set, by the median of radius / (scale * radius of the table); then each by itself.
/// Joints that are missing keep theirs.
/// @param scale size of the hand, above 0
/// @return one line that says which radii were replaced, and why, without the name of the hand; empty: none
std::string replaceRadii(TrackedHand& hand, double scale);

/// The minimum factor, at most 1, by which all radii of a hand may be multiplied so that `replaceRadii` keeps
/// them. For hands whose radii it keeps.
double minimumRadiusFactor(const TrackedHand& hand);

}  // namespace tactile_clay::hand
