#pragma once

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

namespace tactile_clay::values {

/// Checks of ranges. An error is one line, which begins with `name`, such as "parameter /node/key". NaN is
/// never in a range.

/// @throws Error if the value is outside [low, high]
template <typename Error = std::invalid_argument, typename T>
void requireIn(const std::string& name, const T& value, const T& low, const T& high) {
  if (value >= low && value <= high) return;
  std::ostringstream line;
  line << name << ": expected a number from " << low << " to " << high << ", got " << value;
  throw Error(line.str());
}

/// @throws std::invalid_argument if the value is below low, or infinite
inline void requireAtLeast(const std::string& name, double value, double low) {
  if (value >= low && std::isfinite(value)) return;
  std::ostringstream line;
  line << name << ": expected a finite number of at least " << low << ", got " << value;
  throw std::invalid_argument(line.str());
}

/// @throws std::invalid_argument if the value is not above low, or infinite
inline void requireAbove(const std::string& name, double value, double low) {
  if (value > low && std::isfinite(value)) return;
  std::ostringstream line;
  line << name << ": expected a finite number above " << low << ", got " << value;
  throw std::invalid_argument(line.str());
}

}  // namespace tactile_clay::values
