#pragma once

#include <Eigen/Core>

namespace tactile_clay::clay {

/// Pair loops run over lanes of eight neighbours. The lane width is a property of the data, not of the
/// processor, so that sums are formed in the same order, and results are equal to the bit, on every machine.
constexpr int lane_width = 8;
using Lane = Eigen::Array<float, lane_width, 1>;

/// Sum of the eight lanes in a fixed order.
inline float sum(const Lane& a) {
  return ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7]));
}

}  // namespace tactile_clay::clay
