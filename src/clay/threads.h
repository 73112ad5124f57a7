#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>

namespace tactile_clay::clay {

/// Runs f(first, last) for ranges of at most `grain` that make up [0, n). Every f must be independent of all
/// others: results then do not depend on the number of threads.
template <typename F>
void parallelRanges(std::size_t n, std::size_t grain, const F& f) {
  const std::size_t ranges = (n + grain - 1) / grain;
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, ranges, 1),
      [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t k = range.begin(); k != range.end(); ++k) f(k * grain, std::min(n, (k + 1) * grain));
      },
      tbb::simple_partitioner());
}

/// Runs f(i) for i in [0, n). Every f(i) must be independent of all others: results then do not depend on the
/// number of threads.
template <typename F>
void parallelFor(std::size_t n, std::size_t grain, const F& f) {
  if (n <= grain) {
    for (std::size_t i = 0; i < n; ++i) f(i);
    return;
  }
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, n, grain),
      [&f](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) f(i);
      },
      tbb::simple_partitioner());
}

}  // namespace tactile_clay::clay
