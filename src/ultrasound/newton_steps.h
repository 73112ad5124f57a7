#pragma once

#include <vector>

#include "ultrasound/propagator.h"

namespace tactile_clay::ultrasound {

/// What is asked of a focus besides its amplitude.
struct FocusShape {
  bool peak;    // whether it is to be a peak in its plane of equal z
  float width;  // of its parabola when it is alone
};

/// Error of the amplitude that is farthest from their mean, over the mean.
float worstError(const Eigen::ArrayXf& amplitude);

/// Turns the drives by the smallest change of phases dphi = J^T (J J^T)^-1 (s b - |p|), J = d|p| / dphi, that
/// gives all foci the same amplitude and, where they are to be peaks, no slope that moves a peak too far and
/// no parabola that is too flat; damped further (Levenberg-Marquardt) until the error falls, repeated until
/// there is none.
/// @param wavenumber rad/m
/// @param free 1 where a phase may change, 0 where not; `g.width` lanes
/// @param shapes of the foci, or empty: amplitudes are all that counts. Peaks that cannot be had are given up
/// @param q drives, of any amplitudes, which they keep nearly
/// @param p out: G q
void newtonSteps(const Propagator& g, double wavenumber, const LaneArray<Lanes>& free,
                 std::vector<FocusShape>& shapes, DriveLanes& q, FocusField& p);

}  // namespace tactile_clay::ultrasound
