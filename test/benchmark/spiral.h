#pragma once

#include <Eigen/Core>
#include <cmath>

namespace tactile_clay {

/// Place of the m-th of samples that are some 5 mm apart, m. They are on a spiral, like the seeds of a
/// sunflower (Vogel 1979), and each has the same area.
inline Eigen::Vector2d onSpiral(int m) {
  const double distance = 0.0028 * std::sqrt(m + 0.5), angle = 2.399963 * m;  // the golden angle
  return {distance * std::cos(angle), distance * std::sin(angle)};
}

}  // namespace tactile_clay
