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

}  // namespace tactile_clay::clay
