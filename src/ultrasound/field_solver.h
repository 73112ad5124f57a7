#pragma once

#include <string>
#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/focal_point.h"

namespace tactile_clay::ultrasound {

constexpr int max_patterns = 8;  // patterns of a field that take turns in a frame

struct FieldSolverOptions {
  /// mu of the objective: the squared relative error that a pressure higher by the factor exp(1) may cost.
  double strength = 0.03;
  int patterns = 1;               // that take turns: 1, 2, 4 or `max_patterns`; these share a period evenly
  int evaluations = 40;           // of the objective per frame, 1 to 10000
  double amplitude = 1.0;         // maximum of each transducer, above 0, at most 1
  int phase_levels = 0;           // steps per turn of the device's phases, 2 to 65536; 0: any phase
  int amplitude_levels = 0;       // steps from 0 to 1 of the device, 1 to 65536; 0: any amplitude
  double max_phase_change = 0.0;  // of a transducer since the drive before, rad; 0: no limit
  /// m, sigma of the Gaussian with which skin blurs pressure. The error in the objective is that of
  /// blurred pressures; FieldSolution::error is not. 0: none
  double blur = 0.0;

  /// @throws std::invalid_argument naming the option, its value and its range
  void validate() const;
};

struct FieldSolution {
  std::vector<Drive> drives;    // one per pattern; one amplitude for all; silent if nothing is wanted
  std::vector<double> reach;    // Pa, amplitude of the whole array when all of it is focused at each target
  std::vector<double> wanted;   // Pa, amplitude wanted at each target: its intensity times `reach`
  std::vector<double> reached;  // Pa, root mean square over the patterns of the amplitude without skin there
  std::vector<double> on_skin;  // Pa, the same of the amplitude on skin, which presses (acoustic_field.h)
  double error = 0.0;           // relative RMS error of the radiation pressure at the best common scale,
                                // neither blurred nor weighted
  double scale = 0.0;           // that scale: mean radiation pressure on the contact over the wanted one
};

/// Finds the phases whose radiation pressure is closest to the wanted one, on touched and on bare skin.
///
/// I_m is the mean over the patterns of |sum_n G_mn a e^{i phi_n}|^2 at target m, the square of the amplitude
/// on skin. So G_mn is the pressure of transducer n there, times the cosine of its incidence on the skin
/// (acoustic_field.h); without a normal, the cosine counts as 1. With t_m, the square of the amplitude wanted
/// there, and B = sum I t / sum t^2, the best common scale, it minimises over the phases
///
///   e^2 + mu h(-ln B),   e^2 = 1 - (sum I t)^2 / (sum I^2 sum t^2),
///
/// where e is the relative RMS error of I at that scale, and B is the mean pressure on the contact over the
/// wanted one. h(x) is 0 if there is enough pressure (x <= 0), x^2 / (2 d) up to d = 1/2, and x - d / 2
/// above. So mu, `strength`, is the price of pressure in error. If the array can give the wanted pressure,
/// the rest of its power goes to places without skin. If it cannot, a pressure that is higher by the factor
/// exp(1) may cost mu more of squared error. Then all amplitudes are lowered together until B is at most 1.
///
/// If `blur` s is not 0, I and t are blurred as skin blurs them: means over the targets n around m, weighted
/// by exp(-|x_m - x_n|^2 / (2 s^2)). If targets have weights, each sum over targets is weighted by them.
///
/// The method is L-BFGS (Liu & Nocedal 1989, doi 10.1007/BF01589116). It starts from the better of two sets
/// of phases, compared after one step from each: the phases before, and those that send sqrt(t) to all
/// targets at once. So a field is continued while it follows the skin, and is found anew if it does not. With
/// `max_phase_change` it starts from the phases before only. Rounded phases are the closest levels.
/// Deterministic, to the bit on every processor; single precision.
/// @param targets samples of skin in the frame of the array, each for the same area. Their intensity is the
///   wanted share of `reach`. If all are 0, or no transducer is in front of any wanted sample, the drives are
///   silent. Targets behind the array do not count. The length of a normal does not count
/// @param before drives of the frame before, or none
/// @throws std::invalid_argument if an option, a position, normal or intensity is out of range, or a drive
///   before is not finite or not of the layout's length
FieldSolution solveField(const ArrayLayout& layout, const Acoustics& acoustics,
                         const std::vector<FocalPoint>& targets, const FieldSolverOptions& options = {},
                         const std::vector<Drive>& before = {});

/// How close a field is to the wanted one.
struct FieldFit {
  double error = 0.0;  // relative RMS error of the radiation pressure at the best common scale
  double scale = 0.0;  // that scale
};
/// @param wanted, given amplitudes of the same length, Pa; on skin
/// @return error 0 if nothing is wanted, 1 if all of `given` is 0
FieldFit fieldFit(const std::vector<double>& wanted, const std::vector<double>& given);

/// Whether any target has a normal: otherwise nothing differs on skin.
bool knowSkin(const std::vector<FocalPoint>& targets);

/// Amplitudes on skin at the targets (acoustic_field.h), Pa: root of the mean square over drives that take
/// equal turns.
/// @throws as pressuresAt
std::vector<float> amplitudesOnSkin(const ArrayLayout& layout, const Acoustics& acoustics,
                                    const std::vector<Drive>& drives, const std::vector<FocalPoint>& targets);

/// Computes `reached`, `on_skin`, `error` and `scale` of a solution anew from the field of its drives
/// (acoustic_field.h), for drives that a device has changed.
void judgeField(const ArrayLayout& layout, const Acoustics& acoustics, const std::vector<FocalPoint>& targets,
                FieldSolution& solution);

}  // namespace tactile_clay::ultrasound
