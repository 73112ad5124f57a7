#pragma once

#include <vector>

#include "ultrasound/propagator.h"

namespace tactile_clay::ultrasound {

constexpr float tiny_amplitude = 1e-20f;  // keeps divisions by an amplitude finite

/// What is asked of a focus besides its amplitude.
struct FocusShape {
  bool peak;    // whether it is to be a peak in its plane of equal z
  float width;  // of its parabola when it is the only focus
};

/// Error of the amplitude that is farthest from their mean, over the mean.
float worstError(const Eigen::ArrayXf& amplitude);

/// Corrects the phases of the drives in steps dphi = J^T (J J^T)^-1 (s b - |p|), J = d|p| / dphi: the
/// smallest change that gives all foci the same amplitude. Foci that are to be peaks get a slope so small
/// that the peak is not too far away, and a parabola that is not too flat. Each step is damped further
/// (Levenberg-Marquardt) until the error falls. Steps are repeated until there is no error.
/// @param wavenumber rad/m
/// @param free 1 if a phase may change, otherwise 0; `g.width` lanes
/// @param shapes of the foci, or empty: only amplitudes count. `peak` becomes false for foci that cannot be
///   peaks
/// @param q drives, of any amplitudes, which hardly change
/// @param p out: G q
void newtonSteps(const Propagator& g, double wavenumber, const LaneArray<Lanes>& free,
                 std::vector<FocusShape>& shapes, DriveLanes& q, FocusField& p);

}  // namespace tactile_clay::ultrasound
