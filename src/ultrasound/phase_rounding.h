#pragma once

#include <vector>

#include "ultrasound/propagator.h"

namespace tactile_clay::ultrasound {

/// How far a phase may be from the one before.
struct PhaseLimit {
  LaneArray<Lanes> before;  // turns
  LaneArray<Lanes> change;  // turns, at least 0; above 1/2: no limit
};

/// Brings each phase of `q` within the limit.
/// @return 1 where it was, 0 where it had to be moved
LaneArray<Lanes> limitPhases(const PhaseLimit& limit, DriveLanes& q);

/// Rounds the phases of `q` to `levels` steps of the turn so that the |p| of the foci stay what they are: the
/// transducers are taken in turn, and each takes that of its two closest levels that leaves the smaller sum
/// of squared errors of all foci, the errors of those before it included (error diffusion, as in sigma-delta
/// converters and halftoning). Rounding each to its closest level adds the errors at random instead, 0.8 %
/// for eight foci on 256 transducers at 32 levels.
/// @param limit phases to stay within it; where no level is, the one closest to the phase before. Or null
/// @return level of each transducer, 0 to levels - 1, in lanes
LaneArray<Lanes> roundPhases(const Propagator& g, const DriveLanes& q, int levels, const PhaseLimit* limit);

}  // namespace tactile_clay::ultrasound
