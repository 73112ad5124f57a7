#pragma once

#include <vector>

#include "ultrasound/propagator.h"

namespace tactile_clay::ultrasound {

/// How far each phase may be from the phase before.
struct PhaseLimit {
  LaneArray<Lanes> before;  // turns
  LaneArray<Lanes> change;  // turns, at least 0; above 1/2: no limit
};

/// Brings each phase of `q` within the limit.
/// @return 1 for a phase that was within it, 0 for a phase that was moved
LaneArray<Lanes> limitPhases(const PhaseLimit& limit, DriveLanes& q);

/// Rounds the phases of `q` to `levels` steps per turn so that the |p| of the foci stay as they are. The
/// transducers are rounded one after the other. Each takes the one of its two closest levels that leaves the
/// smaller sum of squared errors of all foci, with the errors of the transducers before it (error diffusion,
/// as in sigma-delta converters and halftoning). If each were rounded to its closest level, the errors would
/// add up at random: 0.8 % for eight foci on 256 transducers at 32 levels.
/// @param limit phases stay within it; if no level is within it, the level closest to the phase before is
///   taken. Or null
/// @return level of each transducer, 0 to levels - 1, in lanes
LaneArray<Lanes> roundPhases(const Propagator& g, const DriveLanes& q, int levels, const PhaseLimit* limit);

}  // namespace tactile_clay::ultrasound
