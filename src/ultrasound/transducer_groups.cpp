#include "ultrasound/transducer_groups.h"

#include <algorithm>
#include <numeric>

namespace tactile_clay::ultrasound {
namespace {

constexpr std::size_t smallest_group = 4;  // transducers

/// Halves a range of transducers along its longest side, and its halves again, down to the last depth.
void halve(const ArrayLayout& layout, std::vector<std::uint32_t>::iterator begin,
           std::vector<std::uint32_t>::iterator end, std::size_t depth, TransducerGroups& groups) {
  groups.ends[depth].push_back(static_cast<std::uint32_t>(end - groups.order.begin()));
  if (depth + 1 == groups.ends.size()) return;
  Eigen::Vector3d low = layout.position[*begin], high = low;
  for (auto n = begin; n != end; ++n) {
    low = low.cwiseMin(layout.position[*n]);
    high = high.cwiseMax(layout.position[*n]);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](std::uint32_t a, std::uint32_t b) {
    const double x = layout.position[a][axis], y = layout.position[b][axis];
    return x < y || (x == y && a < b);
  });
  halve(layout, begin, middle, depth + 1, groups);
  halve(layout, middle, end, depth + 1, groups);
}

}  // namespace

TransducerGroups::TransducerGroups(const ArrayLayout& layout) : order(layout.size()) {
  std::iota(order.begin(), order.end(), 0u);
  std::size_t depths = 1;
  while (smallest_group << (depths - 1) < layout.size()) ++depths;
  ends.resize(depths);
  halve(layout, order.begin(), order.end(), 0, *this);
}

}  // namespace tactile_clay::ultrasound
