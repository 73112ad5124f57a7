#pragma once

#include "clay/kernel.h"

#include <cmath>

namespace tactile_clay::clay {

/// Kernel sum at an inner point of the initial cubic lattice, 1/m^3. Densities are ratios to it, so that a
/// block neither swells nor settles at the start, whatever its material.
inline float latticeSum(const Kernel& kernel, float spacing) {
  const int reach = static_cast<int>(std::ceil(kernel.h / spacing));
  double total = 0.0;
  for (int x = -reach; x <= reach; ++x) {
    for (int y = -reach; y <= reach; ++y) {
      for (int z = -reach; z <= reach; ++z) {
        total += kernel.value(spacing * std::sqrt(static_cast<float>(x * x + y * y + z * z)));
      }
    }
  }
  return static_cast<float>(total);
}

/// Share of the lattice sum that comes from one side of a point, without the plane through the point. A point
/// in the outermost layer lacks this share.
inline float wallShare(const Kernel& kernel, float spacing) {
  const int reach = static_cast<int>(std::ceil(kernel.h / spacing));
  double plane = 0.0;
  for (int x = -reach; x <= reach; ++x) {
    for (int y = -reach; y <= reach; ++y)
      plane += kernel.value(spacing * std::sqrt(static_cast<float>(x * x + y * y)));
  }
  return static_cast<float>(0.5 * (1.0 - plane / latticeSum(kernel, spacing)));
}

}  // namespace tactile_clay::clay
