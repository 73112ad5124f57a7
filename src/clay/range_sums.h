#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "clay/threads.h"

namespace tactile_clay::clay {

/// Three sums, and a maximum, over particles.
struct Sums {
  double first = 0.0, second = 0.0, third = 0.0;
  float largest = 0.0f;
  Sums& operator+=(const Sums& other) {
    first += other.first;
    second += other.second;
    third += other.third;
    largest = std::max(largest, other.largest);
    return *this;
  }
};

/// Forms sums over fixed ranges of particles and adds them in order: the same bits for any number of threads.
class RangeSums {
 public:
  /// @param f f(first, last) gives the sums over particles [first, last) of [0, n)
  template <typename F>
  Sums of(std::size_t n, const F& f) {
    parts_.assign((n + range_size - 1) / range_size, Sums());
    parallelRanges(n, range_size,
                   [&](std::size_t first, std::size_t last) { parts_[first / range_size] = f(first, last); });
    Sums total;
    for (const Sums& part : parts_) total += part;
    return total;
  }

 private:
  std::vector<Sums> parts_;
};

}  // namespace tactile_clay::clay
