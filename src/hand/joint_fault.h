#pragma once

#include <array>
#include <sstream>
#include <string>

#include "hand/anatomy.h"

namespace tactile_clay::hand {

/// Names of the fingers in log lines.
inline constexpr std::array<const char*, finger_count> finger_names = {
    "thumb", "index finger", "middle finger", "ring finger", "little finger"};

/// What was expected of a quantity, such as "0.4 to 2 m". The unit comes with its space.
inline std::string range(double low, double high, const char* unit) {
  std::ostringstream text;
  text.precision(2);
  text << low << " to " << high << unit;
  return text.str();
}

/// The line about a wrong joint: which quantity, its value, what was expected.
template <typename Value>
std::string jointFault(int joint, const char* what, const Value& value, const std::string& expected) {
  std::ostringstream line;
  line.precision(3);
  line << "joint " << joint_anatomy[joint].name << ": " << what << " " << value << ", expected " << expected;
  return line.str();
}

}  // namespace tactile_clay::hand
