#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "clay/thread_team.h"

namespace tactile_clay::clay {

/// Consecutive pieces of work that belong to one thread. It takes pieces from the front, the others from the
/// back.
class Share {
 public:
  static constexpr std::uint32_t none = 0xffffffffu;

  void give(std::uint32_t begin, std::uint32_t end) {
    left_ = static_cast<std::uint64_t>(end) << 32u | begin;
  }
  std::uint32_t takeFirst() {
    return take([](std::uint32_t& begin, std::uint32_t&) { return begin++; });
  }
  std::uint32_t takeLast() {
    return take([](std::uint32_t&, std::uint32_t& end) { return --end; });
  }

 private:
  template <typename F>
  std::uint32_t take(const F& f) {
    std::uint64_t left = left_;
    for (;;) {
      std::uint32_t begin = static_cast<std::uint32_t>(left), end = static_cast<std::uint32_t>(left >> 32u);
      if (begin >= end) return none;
      const std::uint32_t taken = f(begin, end);
      if (left_.compare_exchange_weak(left, static_cast<std::uint64_t>(end) << 32u | begin)) return taken;
    }
  }
  alignas(64) std::atomic<std::uint64_t> left_;
};

/// Number of particles of a range in loops over particles. Loops with the same number give a thread the same
/// particles, and sums over ranges keep their order.
constexpr std::size_t range_size = 256;

/// Runs f(first, last) for ranges of at most `grain` that make up [0, n). Every call must be independent of
/// all others: results then do not depend on the number of threads.
///
/// In every call with the same grain a thread starts with the same part of [0, n), so that data which it
/// wrote is in its own cache when it reads it. TBB's partitioners distribute the parts anew. If two cores
/// share no cache, fetching cache lines from the other core takes longer than the work.
template <typename F>
void parallelRanges(std::size_t n, std::size_t grain, const F& f) {
  constexpr std::uint32_t max_threads = 64;
  const auto ranges = static_cast<std::uint32_t>((n + grain - 1) / grain);
  const auto run = [&](std::uint32_t k) { f(k * grain, std::min(n, (k + 1) * grain)); };
  ThreadTeam* const team = ThreadTeam::current();
  const std::uint32_t threads = team == nullptr ? 1 : std::min({ranges, max_threads, team->size()});
  if (threads < 2) {
    for (std::uint32_t k = 0; k < ranges; ++k) run(k);
    return;
  }
  Share shares[max_threads];
  for (std::uint32_t t = 0; t < threads; ++t)
    shares[t].give(ranges * t / threads, ranges * (t + 1) / threads);
  team->run(threads, [&](std::uint32_t own) {
    for (std::uint32_t k; (k = shares[own % threads].takeFirst()) != Share::none;) run(k);
    for (std::uint32_t t = 1; t < threads; ++t)
      for (std::uint32_t k; (k = shares[(own + t) % threads].takeLast()) != Share::none;) run(k);
  });
}

/// Runs f(i) for i in [0, n), by ranges of at most `grain`, as `parallelRanges`.
template <typename F>
void parallelFor(std::size_t n, std::size_t grain, const F& f) {
  parallelRanges(n, grain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) f(i);
  });
}

}  // namespace tactile_clay::clay
