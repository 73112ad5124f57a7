#pragma once

#include <Eigen/Core>
#include <boost/container/small_vector.hpp>
#include <cstdint>
#include <utility>
#include <vector>

#include "clay/neighbourhood.h"
#include "clay/threads.h"

namespace tactile_clay::clay {

/// Calls f(lump, from, to) for each run of consecutive particles of one lump in [first, last).
template <typename F>
void forRuns(const Neighbourhood& near, std::size_t first, std::size_t last, const F& f) {
  for (std::size_t from = first, to = first; from < last; from = to) {
    const std::uint32_t lump = near.lump(from);
    if (near.lumps() == 1) to = last;
    while (to < last && near.lump(to) == lump) ++to;
    f(lump, from, to);
  }
}

/// One value per lump. Up to four lumps need no heap memory.
template <typename Value>
using OfLumps = boost::container::small_vector<Value, 4>;

/// Sums over the runs of each lump. They are formed in fixed ranges of particles and added in order, so the
/// bits do not depend on the number of threads.
template <typename Sum>
class RunSums {
 public:
  /// @param f f(lump, from, to) returns the sum over particles [from, to) of [0, n), all of this lump
  /// @return one sum per lump
  template <typename F>
  OfLumps<Sum> of(const Neighbourhood& near, std::size_t n, const Sum& none, const F& f) {
    ranges_.resize((n + range_size - 1) / range_size);
    parallelRanges(n, range_size, [&](std::size_t first, std::size_t last) {
      Parts& parts = ranges_[first / range_size];
      parts.clear();
      forRuns(near, first, last, [&](std::uint32_t lump, std::size_t from, std::size_t to) {
        parts.emplace_back(lump, f(lump, from, to));
      });
    });
    OfLumps<Sum> totals(near.lumps(), none);
    for (const Parts& parts : ranges_)
      for (const auto& [lump, sum] : parts) totals[lump] += sum;
    return totals;
  }

 private:
  using Parts = std::vector<std::pair<std::uint32_t, Sum>>;  // one sum per run of a range
  std::vector<Parts> ranges_;                                // one per range; kept so that memory is reused
};

/// Sums over the particles of each lump.
template <int size>
class LumpSums {
 public:
  using Sum = Eigen::Matrix<double, size, 1>;

  /// @param f f(i) returns the summand of particle i of [0, n)
  /// @return one sum per lump
  template <typename F>
  OfLumps<Sum> of(const Neighbourhood& near, std::size_t n, const F& f) {
    const Sum none = Sum::Zero();
    return runs_.of(near, n, none, [&](std::uint32_t, std::size_t from, std::size_t to) {
      Sum sum = none;
      for (std::size_t i = from; i < to; ++i) sum += f(i);
      return sum;
    });
  }

 private:
  RunSums<Sum> runs_;
};

}  // namespace tactile_clay::clay
