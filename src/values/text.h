#pragma once

#include <cstdio>
#include <string>

namespace tactile_clay::values {

/// A number as text with six significant digits.
inline std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

}  // namespace tactile_clay::values
