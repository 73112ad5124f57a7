#pragma once

#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/focal_point.h"

namespace tactile_clay::ultrasound {

struct PhaseSolverOptions {
  int iterations = 100;  // of weighted Gerchberg-Saxton, 1 to 1000; one point needs none
};

struct PhaseSolution {
  Drive drive;
  std::vector<double> target;   // of each point, Pa peak; 0 where it takes no part
  std::vector<double> reached;  // of each point, Pa peak, by this drive; 0 where it takes no part
};

/// Peak pressure (Pa) that the whole array gives at one point when all of it is focused there: sum of |G_n|.
double focusPressure(const ArrayLayout& layout, const Acoustics& acoustics, const Eigen::Vector3d& point);

/// Phases, and one common amplitude, that put each focal point at its share of what the array can give there
/// for that number M of points: intensity x focusPressure / sqrt(M) (M foci share the array's power, so that
/// each falls as 1/sqrt(M)).
///
/// One point: the exact answer, phi_n = -arg G_n. Several: weighted Gerchberg-Saxton over phases of the unit
/// drive (Di Leonardo et al. 2007, Opt. Express 15:1913): after each pass the weight of a focus is multiplied
/// by (target / |p|)^e. With e = 1 two foci can swing for ever and with e = 1/2 a few still do, so each focus
/// has its own e, adapted by the sign of its error as in Rprop (Riedmiller & Braun 1993). Then all amplitudes
/// are lowered together to what the targets need; where they need more than the array has, all foci fall
/// short by the same factor (see `reached`).
///
/// Points below intensity 0.001 or behind the array take no part (and do not count in M); none at all: every
/// amplitude is 0. Deterministic.
/// \param points in the frame of the array
/// \param warm_start a drive to take the first phases of the foci from, such as that of the frame before; or
///   null
/// \throws std::invalid_argument if an option, a position or an intensity is out of range, or the warm start
///   is not finite and of the layout's length
PhaseSolution solvePhases(const ArrayLayout& layout, const Acoustics& acoustics,
                          const std::vector<FocalPoint>& points, const PhaseSolverOptions& options = {},
                          const Drive* warm_start = nullptr);

}  // namespace tactile_clay::ultrasound
