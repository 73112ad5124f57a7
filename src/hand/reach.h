#pragma once

#include <array>

#include "hand/anatomy.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// The hand as anatomy lets it be: capsule and ligaments limit how far a bone turns on the one before it, and
/// the bones of one person are in proportion. A hand within reach stays as it is. A finger outside its reach
/// is moved toward the middle of it, from its root on, as far as necessary.
///
/// A finger has less reach the farther its root and lengths are from those of a hand, and a thumb also the
/// nearer its metacarpal is to the index finger's. A finger that is too far from any person's proportions is
/// put into the middle of its reach. The same is done with a finger with missing joints; then all its joints
/// are set. The error of the palm is the median of the errors of the five fingers: no finger has more reach
/// than this error allows.
/// @param share of the reach that each finger is given, 0 to 1: at 0 it is put into the middle
TrackedHand withinReach(const TrackedHand& tracked, const std::array<double, finger_count>& share);
TrackedHand withinReach(const TrackedHand& tracked);  // with all of the reach

}  // namespace tactile_clay::hand
