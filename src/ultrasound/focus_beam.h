#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace tactile_clay::ultrasound {

/// What the whole array makes of one focus. With s the unit vector from each transducer to it, weighted by
/// amplitude: at a small way d aside the amplitude has fallen by the share k^2 d^T spread d / 2.
struct FocusBeam {
  float reach = 0.0f;                                // Pa, sum of the amplitudes of all transducers
  Eigen::Matrix3f spread = Eigen::Matrix3f::Zero();  // covariance of s
};

/// How far apart two foci are for the array: k sqrt(d^T spread d) with the mean of their spreads. 2.2 is the
/// width of a focus at half its amplitude. A focus is some six times as long as it is wide, so a way along z
/// counts little.
/// @param way from one to the other, m
/// @param wavenumber rad/m
inline double separation(const Eigen::Vector3d& way, const FocusBeam& a, const FocusBeam& b,
                         double wavenumber) {
  const Eigen::Matrix3d spread = 0.5 * (a.spread + b.spread).cast<double>();
  return wavenumber * std::sqrt(std::max(way.dot(spread * way), 0.0));
}

}  // namespace tactile_clay::ultrasound
