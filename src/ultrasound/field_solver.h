#pragma once

#include <string>
#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/focal_point.h"

namespace tactile_clay::ultrasound {

constexpr int max_patterns = 8;  // of a field, that take turns in a frame

struct FieldSolverOptions {
  /// mu of the objective: what e times the pressure is worth, in squared relative error.
  double strength = 0.03;
  int patterns = 1;               // that take turns: 1, 2, 4 or `max_patterns`, which share a period evenly
  int evaluations = 40;           // of the objective a frame, 1 to 10000
  double amplitude = 1.0;         // most of each transducer, above 0, at most 1
  int phase_levels = 0;           // steps of a turn that the device knows, 2 to 65536; 0: any phase
  int amplitude_levels = 0;       // steps from 0 to 1 that the device knows, 1 to 65536; 0: any amplitude
  double max_phase_change = 0.0;  // of a transducer since the drive before, rad; 0: no limit
  double blur = 0.0;  // m, of the Gaussian with which skin blurs pressure before its error counts; 0: none

  /// @throws std::invalid_argument naming the option, its value and its range
  void validate() const;
};

struct FieldSolution {
  std::vector<Drive> drives;    // a pattern each; all of one amplitude; silent where nothing is wanted
  std::vector<double> reach;    // Pa, amplitude of the whole array when all of it is focused at each target
  std::vector<double> wanted;   // Pa, amplitude wanted at each target: its intensity times `reach`
  std::vector<double> reached;  // Pa, root mean square over the patterns of the amplitude there
  double error = 0.0;           // relative RMS error of the radiation pressure at the best common scale, as
                                // it is, neither blurred nor weighted
  double scale = 0.0;           // that scale: mean radiation pressure where it is wanted, over the wanted one
};

/// The phases whose radiation pressure comes closest to what is wanted on the skin, touched and not.
///
/// With I_m = mean over the patterns of |sum_n G_mn a e^{i phi_n}|^2 at target m, t_m the square of the
/// amplitude wanted there, and B = sum I t / sum t^2 the best common scale, it minimises over the phases
///
///   e^2 + mu h(-ln B),   e^2 = 1 - (sum I t)^2 / (sum I^2 sum t^2),
///
/// e being the relative RMS error of I at that scale, so that sum I t / sum t^2 is the mean pressure on the
/// contact over the wanted one; h(x) is 0 where there is enough (x <= 0), x^2 / (2 d) up to d = 1/2 and
/// x - d / 2 above. So mu, `strength`, is the price of pressure in error: where the array can give what is
/// wanted, the rest of its power goes where there is no skin; where it cannot, e times the pressure is worth
/// mu more of squared error. All amplitudes are then lowered together until B is at most 1.
///
/// Where `blur` s is not 0, I and t are those that the skin can tell apart: means over the targets n around m
/// by exp(-|x_m - x_n|^2 / (2 s^2)). Where targets have weights, each sum over targets is by them.
///
/// L-BFGS (Liu & Nocedal 1989, doi 10.1007/BF01589116) from the better of two starts after a step each: the
/// phases before, and those that send sqrt(t) to all targets at once. So a field goes on while it follows the
/// skin, and starts anew where it does not. Rounded phases are the closest levels. Deterministic, to the bit
/// on every processor; single precision.
/// @param targets samples of skin, frame of the array, each standing for as much of it as the others; their
///   intensity is the share of `reach` that is wanted. At least one that is not 0, or all is silent. Targets
///   behind the array count as not there
/// @param before drives of the frame before, or none
/// @throws std::invalid_argument if an option, a position or an intensity is out of range, or a drive before
///   is not finite and of the layout's length
FieldSolution solveField(const ArrayLayout& layout, const Acoustics& acoustics,
                         const std::vector<FocalPoint>& targets, const FieldSolverOptions& options = {},
                         const std::vector<Drive>& before = {});

/// How well a field stands for the wanted one.
struct FieldFit {
  double error = 0.0;  // relative RMS error of the radiation pressure at the best common scale
  double scale = 0.0;  // that scale
};
/// @param wanted, reached amplitudes of the same length, Pa
/// @return error 0 where nothing is wanted, 1 where nothing of it is had
FieldFit fieldFit(const std::vector<double>& wanted, const std::vector<double>& reached);

/// Sets `reached`, `error` and `scale` of a solution to what the field of its drives is (acoustic_field.h),
/// whatever a device has made of these.
void judgeField(const ArrayLayout& layout, const Acoustics& acoustics, const std::vector<FocalPoint>& targets,
                FieldSolution& solution);

}  // namespace tactile_clay::ultrasound
