#pragma once

#include <string>
#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/focal_point.h"

namespace tactile_clay::ultrasound {

enum class PhaseMethod {
  naive,                      // q = G^H b: each focus as if it were the only one
  weighted_gerchberg_saxton,  // damped
  gs_pat,                     // Gerchberg-Saxton among the foci
  newton                      // Gerchberg-Saxton, then minimum-norm Newton steps: exact
};

/// The method of a name, as parameters have it: `naive`, `weighted_gerchberg_saxton`, `gs_pat`, `newton`.
/// @throws std::invalid_argument listing the names
PhaseMethod phaseMethod(const std::string& name);

struct PhaseSolverOptions {
  PhaseMethod method = PhaseMethod::newton;
  int iterations = 5;             // passes of Gerchberg-Saxton, 1 to 1000; one point needs none
  bool peaks = true;              // newton: foci are peaks in planes of equal z, not on the slope of others
  bool phase_only = true;         // one amplitude for all transducers; otherwise each has its own
  int phase_levels = 0;           // steps per turn of the device's phases, 2 to 65536; 0: any phase
  int amplitude_levels = 0;       // steps from 0 to 1 of the device, 1 to 65536; 0: any amplitude
  double max_phase_change = 0.0;  // of a transducer since the drive before, rad; 0: no limit
};

struct PhaseSolution {
  Drive drive;
  std::vector<double> target;   // of each point, Pa peak; 0 if it takes no part
  std::vector<double> reached;  // of each point, Pa peak, by this drive; 0 if it takes no part
};

/// Peak pressure (Pa) that the whole array gives at one point when all of it is focused there: sum of |G_n|.
double focusPressure(const ArrayLayout& layout, const Acoustics& acoustics, const Eigen::Vector3d& point);

/// The drive that gives each focal point its share of the amplitude that the array can give there to each of
/// M points: intensity x focusPressure / sqrt(M). (M foci share the array's power, so the amplitude of each
/// falls as 1/sqrt(M).)
///
/// One point: the exact answer, phi_n = -arg G_n. Several points, of target amplitudes b:
/// - `naive`: q = G^H b.
/// - `weighted_gerchberg_saxton`: alternates between the phases of the foci and drives of amplitude 1 (Di
///   Leonardo et al. 2007, Opt. Express 15:1913); after each pass the weight of a focus is multiplied by
///   (b / |p|)^e. With e = 1 two foci can oscillate for ever, and with e = 1/2 a few still do. So each focus
///   has its own e, adapted by the sign of its error as in Rprop (Riedmiller & Braun 1993).
/// - `gs_pat`: the same without transducers, in the foci x foci matrix G F, where F is G^H with each focus
///   over its energy; weights b^2 / |p| in the end (Plasencia et al. 2020, ACM Trans. Graph. 39:138).
/// - `newton`: first the phases of the foci that give the most power, the best of sixteen ascents of c^H R c
///   in the foci x foci matrix R = G G^H. Then some passes of weighted Gerchberg-Saxton. Then steps dphi =
///   J^T (J J^T)^-1 (s b - |p|) with J = d|p| / dphi, the smallest change of the phases that corrects all
///   amplitudes at once; s is their common scale. Each step solves an M x M system.
///
/// With `peaks`, `newton` keeps foci closer than some two widths off each other's flanks. If the parabola of
/// |p| in the plane of a focus has its top more than 0.7 mm away, its slope gets two rows of J. If the
/// parabola is flat or bends upwards, as at a weak focus between the lobes of strong ones, its width gets one
/// row. Foci that no drive could make separate peaks, less than 1.5 apart (separation()), such as two above
/// each other, are left as they are. Peaks take 1 % of the pressure. Along z, where a focus is long, its peak
/// is nearer to the array by some mm, as it is for a single focus.
///
/// If an amplitude stays more than 1 % off, as for a weak focus above a strong one, `newton` starts again
/// from drives of minimum norm, G^H (G G^H)^-1 p.
///
/// Without `phase_only`, each amplitude is the one of the solution over the mean of all, at most 1:
/// transducers that the foci hardly need are driven less.
///
/// With `phase_levels`, phases are rounded so that the errors cancel at the foci (roundPhases). Then all
/// amplitudes are lowered together as far as the targets allow. If the targets need more than the array has,
/// all foci are too weak by the same factor. `reached` is the pressure of the final drive, rounded and
/// limited.
///
/// Points below intensity 0.001 or behind the array take no part and do not count in M. If no point takes
/// part, every amplitude is 0. Deterministic, to the bit on every processor.
/// @param points in the frame of the array
/// @param before drive of the frame before, or null. It gives the first phases of the foci. If its amplitude
///   at a transducer is above 0, it limits the change of that phase (`max_phase_change`)
/// @throws std::invalid_argument if an option, a position or an intensity is out of range, or the drive
///   before is not finite or not of the layout's length
PhaseSolution solvePhases(const ArrayLayout& layout, const Acoustics& acoustics,
                          const std::vector<FocalPoint>& points, const PhaseSolverOptions& options = {},
                          const Drive* before = nullptr);

}  // namespace tactile_clay::ultrasound
