#pragma once

#include <array>

#include "hand/anatomy.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// The hand as anatomy lets it be: capsule and ligaments end how far a bone turns on the one before it, and
/// the bones of one person are in proportion. From its root on, each finger is led toward the middle of its
/// reach as far as it is outside; the farther its root and lengths are from those of a hand, and the nearer a
/// thumb's metacarpal is to the index finger's, the less reach it has, and what is no finger at all rests in
/// the middle, as does a finger with missing joints, which then has all. As strange as most fingers are, is
/// the palm, from which all are seen: no finger has more reach than that leaves. A hand within reach stays as
/// it is.
/// @param share of the reach that each finger is given, 0 to 1: at 0 it rests
TrackedHand withinReach(const TrackedHand& tracked, const std::array<double, finger_count>& share);
TrackedHand withinReach(const TrackedHand& tracked);  // the same with all of the reach

}  // namespace tactile_clay::hand
