#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace tactile_clay::tools {

/// The value below which a share (0 to 1) of the values lies: one of the values, not interpolated. NaN if
/// there are none.
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return NAN;
  const auto at =
      std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

}  // namespace tactile_clay::tools
