#pragma once

#include <cmath>
#include <cstdio>
#include <locale>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace tactile_clay::values {

/// A number as text with six significant digits.
inline std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

/// The numbers of a text, with white space between them. Their decimal point is a point in every locale.
/// @return nothing if the text has something else in it, or a number that is not finite
inline std::optional<std::vector<double>> numbersOf(const std::string& text) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  std::vector<double> numbers;
  while (!(stream >> std::ws).eof()) {
    double number = 0.0;
    if (!(stream >> number) || !std::isfinite(number)) return std::nullopt;
    numbers.push_back(number);
  }
  return numbers;
}

}  // namespace tactile_clay::values
