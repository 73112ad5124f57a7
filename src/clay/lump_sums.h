#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "clay/neighbourhood.h"
#include "clay/threads.h"

namespace tactile_clay::clay {

/// Sums over the particles of each lump. They are formed over fixed ranges of particles and added in order:
/// the same bits for any number of threads.
template <int size>
class LumpSums {
 public:
  using Sum = Eigen::Matrix<double, size, 1>;

  /// \param f f(i) is what particle i of [0, n) adds \return one sum a lump, valid until the next call
  template <typename F>
  const std::vector<Sum>& of(const Neighbourhood& near, std::size_t n, const F& f) {
    ranges_.resize((n + range_size - 1) / range_size);
    parallelRanges(n, range_size, [&](std::size_t first, std::size_t last) {
      Parts& parts = ranges_[first / range_size];
      parts.clear();
      for (std::size_t i = first; i < last;) {
        const std::uint32_t lump = near.lump(i);
        Sum sum = Sum::Zero();
        for (; i < last && near.lump(i) == lump; ++i) sum += f(i);
        parts.emplace_back(lump, sum);
      }
    });
    totals_.assign(near.lumps(), Sum::Zero());
    for (const Parts& parts : ranges_)
      for (const auto& [lump, sum] : parts) totals_[lump] += sum;
    return totals_;
  }

 private:
  using Parts = std::vector<std::pair<std::uint32_t, Sum>>;  // of a range: runs of particles of one lump
  std::vector<Parts> ranges_;
  std::vector<Sum> totals_;
};

}  // namespace tactile_clay::clay
