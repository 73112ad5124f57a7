#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "ultrasound/focal_point.h"

namespace tactile_clay::ultrasound {

struct SideLobe {
  double share = 0.0;                                  // of the strongest focus's amplitude; 0: none
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // m
};

/// Strongest amplitude of a field away from all foci, over that of the strongest focus.
/// @param at m
/// @param pressure Pa, complex, at each of `at`
/// @param foci m
/// @param achieved amplitude at each focus, Pa
/// @param away minimum distance to every focus, m
/// @throws std::invalid_argument if arrays that belong together differ in length
SideLobe strongestSideLobe(const std::vector<Eigen::Vector3f>& at,
                           const std::vector<std::complex<float>>& pressure,
                           const std::vector<FocalPoint>& foci, const std::vector<double>& achieved,
                           double away);

/// Relative RMS of achieved / commanded about their mean, over the foci that were commanded (above 0); 0 for
/// none.
double relativeError(const std::vector<double>& achieved, const std::vector<double>& commanded);

}  // namespace tactile_clay::ultrasound
