#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <complex>

#include "ultrasound/acoustic_field.h"

namespace tactile_clay::ultrasound {

/// Amplitude on skin (acoustic_field.h) by its definition, in double precision.
/// @param normal outward, unit
inline std::complex<double> amplitudeOnSkin(const ArrayLayout& layout, const Acoustics& air,
                                            const Drive& drive, const Eigen::Vector3d& at,
                                            const Eigen::Vector3d& normal) {
  std::complex<double> sum = 0.0;
  for (std::size_t n = 0; n < layout.size(); ++n) {
    const double cosine = normal.dot((layout.position[n] - at).normalized());
    sum += std::polar<double>(drive.amplitude[n], drive.phase[n]) * std::max(cosine, 0.0) *
           transducerPressure(layout, air, n, at);
  }
  return sum;
}

}  // namespace tactile_clay::ultrasound
