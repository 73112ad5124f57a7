#pragma once

#include <string>
#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/focal_point.h"

namespace tactile_clay::ultrasound {

enum class PhaseMethod {
  naive,                      // q = G^H b: every focus as if it were alone
  weighted_gerchberg_saxton,  // damped
  gs_pat,                     // Gerchberg-Saxton among the foci
  newton                      // some passes of the second, then minimum-norm Newton steps: exact
};

/// Names of the methods, as parameters give them: `naive`, `weighted_gerchberg_saxton`, `gs_pat`, `newton`.
/// @throws std::invalid_argument listing the names
PhaseMethod phaseMethod(const std::string& name);

struct PhaseSolverOptions {
  PhaseMethod method = PhaseMethod::newton;
  int iterations = 5;             // passes of Gerchberg-Saxton, 1 to 1000; one point needs none
  bool peaks = true;              // newton: foci are peaks in planes of equal z, not on the slope of others
  bool phase_only = true;         // one amplitude for all transducers; else each has its own
  int phase_levels = 0;           // steps of a turn that the device knows, 2 to 65536; 0: any phase
  int amplitude_levels = 0;       // steps from 0 to 1 that the device knows, 1 to 65536; 0: any amplitude
  double max_phase_change = 0.0;  // of a transducer since the drive before, rad; 0: no limit
};

struct PhaseSolution {
  Drive drive;
  std::vector<double> target;   // of each point, Pa peak; 0 where it takes no part
  std::vector<double> reached;  // of each point, Pa peak, by this drive; 0 where it takes no part
};

/// Peak pressure (Pa) that the whole array gives at one point when all of it is focused there: sum of |G_n|.
double focusPressure(const ArrayLayout& layout, const Acoustics& acoustics, const Eigen::Vector3d& point);

/// Drive that puts each focal point at its share of what the array can give there for that number M of
/// points: intensity x focusPressure / sqrt(M) (M foci share the array's power, so that each falls as
/// 1/sqrt(M)).
///
/// One point: the exact answer, phi_n = -arg G_n. Several, of target amplitudes b:
/// - `naive`: q = G^H b.
/// - `weighted_gerchberg_saxton`: alternates between the phases of the foci and drives of amplitude 1 (Di
///   Leonardo et al. 2007, Opt. Express 15:1913); after each pass the weight of a focus is multiplied by
///   (b / |p|)^e. With e = 1 two foci can swing for ever and with e = 1/2 a few still do, so each focus has
///   its own e, adapted by the sign of its error as in Rprop (Riedmiller & Braun 1993).
/// - `gs_pat`: the same without transducers, in the foci x foci matrix G F, where F is G^H with each focus
/// over
///   its energy; weights b^2 / |p| in the end (Plasencia et al. 2020, ACM Trans. Graph. 39:138).
/// - `newton`: phases of the foci that give the most power, the best of sixteen ascents of c^H R c in the
///   foci x foci matrix R = G G^H; some passes of weighted Gerchberg-Saxton; then steps
///   dphi = J^T (J J^T)^-1 (s b - |p|) with J = d|p| / dphi, the smallest change of the phases that corrects
///   all amplitudes at once, s being their common scale; M x M to solve. With `peaks`, foci closer than some
///   two widths do not lie on each other's flanks: where the parabola of |p| in the plane of a focus has its
///   top more than 0.7 mm away, its slope gets two rows of J, and where it is flat or bends upwards, as a
///   weak focus does between the lobes of strong ones, its width gets one. Foci that no drive could make
///   peaks of their own, less than 1.5 apart (separation()), such as two above each other, are left as they
///   are. Where an amplitude stays more than 1 % off, as that of a weak focus above a strong one does, it
///   starts anew from drives of minimum norm, G^H (G G^H)^-1 p. Peaks take 1 % of the pressure. Along z,
///   where a focus is long, its peak is nearer to the array by some mm, as it is for a single one.
///
/// Not phase_only: transducers that the foci hardly need are driven less, in proportion up to the mean.
///
/// Phases that the device rounds are rounded so that the errors cancel at the foci (roundPhases). Then all
/// amplitudes are lowered together to what the targets need; where they need more than the array has, all
/// foci fall short by the same factor. `reached` is what the drive gives in the end, rounded and limited.
///
/// Points below intensity 0.001 or behind the array take no part (and do not count in M); none at all: every
/// amplitude is 0. Deterministic, to the bit on every processor.
/// @param points in the frame of the array
/// @param before drive of the frame before, to take the first phases of the foci from and to limit the change
///   from where its amplitude is above 0; or null
/// @throws std::invalid_argument if an option, a position or an intensity is out of range, or the drive
///   before is not finite and of the layout's length
PhaseSolution solvePhases(const ArrayLayout& layout, const Acoustics& acoustics,
                          const std::vector<FocalPoint>& points, const PhaseSolverOptions& options = {},
                          const Drive* before = nullptr);

}  // namespace tactile_clay::ultrasound
