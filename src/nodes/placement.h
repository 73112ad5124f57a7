#pragma once

#include <cstddef>
#include <string>

#include "hand/tracked_hand.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {

/// Removes hands that are not sane, each with one throttled line.
/// \return how many
std::size_t leaveOutBadHands(hand::TrackedFrame& frame);

/// Moves all hands of a frame into `world`; hands that tf2 cannot place are removed.
void placeInWorld(hand::TrackedFrame& frame, const std::string& world, Transforms& transforms);

}  // namespace tactile_clay::nodes
