#pragma once

#include <tbb/cache_aligned_allocator.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "lanes/targets.h"

namespace tactile_clay {

/// Sixteen floats that are worked on together. Width is a property of the data, not of the processor.
constexpr std::size_t wide_lane_count = 16;
/// Aligned by hand, since compilers align to the registers of the processor at hand.
using Lanes = float __attribute__((vector_size(wide_lane_count * sizeof(float)), aligned(64)));
using LaneBits = std::int32_t __attribute__((vector_size(wide_lane_count * sizeof(float)), aligned(64)));

/// A complex number in each lane, such as the drive of sixteen transducers.
struct ComplexLanes {
  Lanes re, im;
};

/// An array of Lanes or ComplexLanes; a template argument loses the alignment, cache lines have it.
template <typename T>
using LaneArray = std::vector<T, tbb::cache_aligned_allocator<T>>;

constexpr std::size_t lanesFor(std::size_t count) {
  return (count + wide_lane_count - 1) / wide_lane_count;
}

TACTILE_CLAY_INLINE LaneBits bits(Lanes a) {
  LaneBits b;
  std::memcpy(&b, &a, sizeof b);
  return b;
}

TACTILE_CLAY_INLINE Lanes number(LaneBits a) {
  Lanes b;
  std::memcpy(&b, &a, sizeof b);
  return b;
}

TACTILE_CLAY_INLINE Lanes max(Lanes a, Lanes b) {
  return a > b ? a : b;
}

TACTILE_CLAY_INLINE Lanes min(Lanes a, Lanes b) {
  return a < b ? a : b;
}

/// Sum of the lanes, in one order: halves onto each other.
TACTILE_CLAY_INLINE float sum(const Lanes& a) {
  using Eight = float __attribute__((vector_size(32)));
  using Four = float __attribute__((vector_size(16)));
  Eight eight[2];
  std::memcpy(eight, &a, sizeof a);
  eight[0] += eight[1];
  Four four[2];
  std::memcpy(four, eight, sizeof four);
  four[0] += four[1];
  return (four[0][0] + four[0][2]) + (four[0][1] + four[0][3]);
}

/// 1/sqrt(a) to rounding for a in [1e-30, 1e30]: the exponent halved, then Newton's iteration. Lanes have no
/// square root of their own that is as fast on every processor.
TACTILE_CLAY_INLINE Lanes inverseRoot(Lanes a) {
  const Lanes half = 0.5f * a;
  Lanes y = number(0x5f3759df - (bits(a) >> 1));
  for (int i = 0; i < 3; ++i) y = y * (1.5f - half * y * y);
  return y;
}

/// 1.5 2^23: there floats are whole, so that adding it to a number rounds it.
constexpr float whole_shift = 12582912.0f;

/// Nearest whole number, for |a| < 2^22.
/// @tparam Number float or Lanes
template <typename Number>
TACTILE_CLAY_INLINE Number nearest(Number a) {
  return (a + whole_shift) - whole_shift;
}

/// cos and sin of a whole turn times t, within 1e-6 for |t| < 1e5 less the rounding of t. Minimax polynomials
/// of the angle to the nearest half turn (Remez); an odd half turn changes both signs.
TACTILE_CLAY_INLINE void unitCircle(Lanes t, Lanes& cosine, Lanes& sine) {
  const Lanes halves = 2.0f * t;
  const Lanes shifted = halves + whole_shift;
  const Lanes x = halves - (shifted - whole_shift);
  const LaneBits sign = bits(shifted) << 31;
  const Lanes u = x * x;
  const Lanes s = x * (3.1415820f + u * (-5.1671428f + u * (2.5418990f + u * -0.55463619f)));
  const Lanes c = 0.99999995f + u * (-4.9347929f + u * (4.0584119f + u * (-1.3318802f + u * 0.21969680f)));
  cosine = number(bits(c) ^ sign);
  sine = number(bits(s) ^ sign);
}

/// Angle of (x, y) in turns, -1/2 to 1/2, within 1e-6; 0 for (0, 0). Minimax polynomial (Remez).
TACTILE_CLAY_INLINE Lanes turnsOf(Lanes x, Lanes y) {
  const Lanes ax = number(bits(x) & 0x7fffffff);
  const Lanes ay = number(bits(y) & 0x7fffffff);
  const Lanes high = max(max(ax, ay), Lanes{} + 1e-30f);
  const Lanes a = min(ax, ay) / high;
  const Lanes u = a * a;
  Lanes t = a * (0.15915132f +
                 u * (-0.052938567f +
                      u * (0.030802908f + u * (-0.018529850f + u * (0.0083790859f + u * -0.0018651582f)))));
  t = ay > ax ? 0.25f - t : t;
  t = x < 0.0f ? 0.5f - t : t;
  return y < 0.0f ? -t : t;
}

/// e^{-d}, within 1e-5 for d in [0, 8]; more counts as 8. Minimax polynomial (Remez) of a sixteenth of it.
TACTILE_CLAY_INLINE Lanes decaying(Lanes d) {
  const Lanes e = min(d, Lanes{} + 8.0f) * (1.0f / 16.0f);
  Lanes y = 0.99999960f + e * (-0.99995959f + e * (0.49934111f + e * (-0.16287646f + e * 0.032568515f)));
  y *= y;
  y *= y;
  y *= y;
  return y * y;
}

/// The same within 1e-6 for d in [0, 1/2], in half the time. Interpolated at Chebyshev nodes.
TACTILE_CLAY_INLINE Lanes slightlyDecaying(Lanes d) {
  return 0.99999959f + d * (-0.99995853f + d * (0.49933049f + d * (-0.16284255f + d * 0.032534632f)));
}

}  // namespace tactile_clay
