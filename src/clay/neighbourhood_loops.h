#pragma once

#include <algorithm>

#include "clay/neighbourhood.h"
#include "clay/threads.h"

namespace tactile_clay::clay {

template <typename F>
void Neighbourhood::forEachNear(const Eigen::Vector3f& centre, float radius, const F& f) const {
  std::array<int, 3> low, high;
  for (int a = 0; a < 3; ++a) {
    if (centre[a] + radius < origin_[a] || (centre[a] - radius - origin_[a]) * per_metre_[a] > size_[a])
      return;
    low[a] = cellAlong(centre[a] - radius, a);
    high[a] = cellAlong(centre[a] + radius, a);
  }
  for (int z = low[2]; z <= high[2]; ++z) {
    for (int y = low[1]; y <= high[1]; ++y) {
      const std::uint32_t from = cell_begin_[cellIndex(low[0], y, z)];
      const std::uint32_t to = cell_begin_[cellIndex(high[0], y, z) + 1];
      for (std::uint32_t k = from; k < to; ++k) f(in_cell_[k]);
    }
  }
}

}  // namespace tactile_clay::clay
