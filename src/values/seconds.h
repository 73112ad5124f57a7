#pragma once

#include <chrono>

namespace tactile_clay::values {

/// A time as a number of seconds, for computations.
inline double seconds(std::chrono::nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace tactile_clay::values
