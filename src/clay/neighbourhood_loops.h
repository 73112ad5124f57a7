#pragma once

#include <algorithm>

#include "clay/neighbourhood.h"
#include "clay/threads.h"

namespace tactile_clay::clay {

template <typename F>
void Neighbourhood::forEachColoured(const F& f) const {
  for (std::size_t c = 0; c < colours; ++c) {
    const std::size_t first = colour_begin_[c];
    parallelFor(colour_begin_[c + 1] - first, 1, [&](std::size_t b) {
      const std::uint32_t block = block_order_[first + b];
      for (std::uint32_t k = block_begin_[block]; k < block_begin_[block + 1]; ++k) f(in_block_[k]);
    });
  }
}

template <typename F>
void Neighbourhood::forEachNear(const Eigen::Vector3f& centre, float radius, const F& f) const {
  std::array<int, 3> low, high;
  for (int a = 0; a < 3; ++a) {
    if (centre[a] + radius < origin_[a] || centre[a] - radius > origin_[a] + size_[a] * cell_) return;
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
