#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace tactile_clay::values {

/// @param name with what it is, such as "parameter /node/key"
/// @tparam Error that is thrown
/// @throws Error with one line unless a number is within [low, high]: NaN is not
template <typename Error = std::invalid_argument, typename T>
void requireIn(const std::string& name, const T& value, const T& low, const T& high) {
  if (value >= low && value <= high) return;
  std::ostringstream line;
  line << name << ": expected a number from " << low << " to " << high << ", got " << value;
  throw Error(line.str());
}

}  // namespace tactile_clay::values
