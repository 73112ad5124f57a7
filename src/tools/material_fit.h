#pragma once

#include <functional>
#include <string>
#include <vector>

#include "clay/material.h"
#include "tools/press_curve.h"

namespace tactile_clay::tools {

struct FitParameter {
  std::string name;
  double value = 0.0;
  /// Of its logarithm: standard error by the curvature of the error about the minimum (Gauss & Newton), as if
  /// what is left over were noise; infinite where the curve does not depend on it.
  double error = 0.0;
  /// Whether its standard error is below a factor of 1.5.
  bool determined() const;
};

struct MaterialFit {
  clay::Material material;
  std::vector<FitParameter> parameters;
  double error = 0.0;  // root mean square of what is left over, over that of the measured forces
  int evaluations = 0;
  std::vector<double> measured, model;  // N, in each window
};

/// Forces of a material in the windows of a measurement.
using ForceModel = std::function<std::vector<double>(const clay::Material&)>;

/// Fits parameters of a material so that its forces are the measured ones: pseudo-Huber loss, so that single
/// strays do not count, over the logarithms of the parameters, by Nelder & Mead from the best of three ratios
/// of stiffness to yield stress.
/// @param start what is not fitted; bulk_modulus is raised to ten times the stiffness where it is less
/// @param yield_stress Pa, a guess
/// @param names some of stiffness, yield_stress, viscosity, relaxation_time, friction
/// @param maximum evaluations, about
/// @throws std::runtime_error for a name that is none
MaterialFit fitMaterial(const ForceModel& forces, const std::vector<double>& measured,
                        const clay::Material& start, double yield_stress,
                        const std::vector<std::string>& names, int maximum);

/// Pa, a guess from the maximum force: a punch presses with 6 tau_y, a bar with sqrt(3) tau_y.
double guessedYieldStress(const PressSetup& setup, const PressCurve& curve);

/// A material file.
/// @param comments lines that stand above it, without their `#`
std::string materialFile(const MaterialFit& fit, const std::vector<std::string>& comments);

}  // namespace tactile_clay::tools
