#pragma once

#include <algorithm>

#include "clay/neighbourhood.h"
#include "clay/threads.h"

namespace tactile_clay::clay {

template <typename F>
void Neighbourhood::forEachRun(const Eigen::Vector3f& low, const Eigen::Vector3f& high, const F& f) const {
  std::array<int, 3> first, last;
  for (int a = 0; a < 3; ++a) {
    if (high[a] < origin_[a] || (low[a] - origin_[a]) * per_metre_[a] > size_[a]) return;
    first[a] = cellAlong(low[a], a);
    last[a] = cellAlong(high[a], a);
  }
  for (int z = first[2]; z <= last[2]; ++z) {
    for (int y = first[1]; y <= last[1]; ++y) {
      const CellRow& row = rows_[rowIndex(y, z)];
      if (!row.meets(first[0], last[0])) continue;
      const std::uint32_t from = cell_begin_[row.cell(first[0])], to = cell_begin_[row.cell(last[0]) + 1];
      if (from < to) f(from, to);
    }
  }
}

}  // namespace tactile_clay::clay
