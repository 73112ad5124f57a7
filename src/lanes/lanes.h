#pragma once

#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "lanes/targets.h"

namespace tactile_clay {

/// Loops run over lanes of eight: neighbours of a particle, tetrahedra of flesh. The lane width is a property
/// of the data, not of the processor, so that sums are formed in the same order, and results are equal to the
/// bit, on every machine.
constexpr int lane_width = 8;
using Lane = float __attribute__((vector_size(32)));
using HalfLane = float __attribute__((vector_size(16)));

#if defined(__clang__) || __GNUC__ >= 12
#define TACTILE_CLAY_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
using LaneMask = std::int32_t __attribute__((vector_size(32)));
#define TACTILE_CLAY_SHUFFLE(a, b, ...) __builtin_shuffle(a, b, LaneMask{__VA_ARGS__})
#endif

TACTILE_CLAY_INLINE Lane all(float x) {
  return Lane{x, x, x, x, x, x, x, x};
}
TACTILE_CLAY_INLINE Lane load(const float* from) {
  Lane lane;
  std::memcpy(&lane, from, sizeof(Lane));
  return lane;
}
TACTILE_CLAY_INLINE void store(float* to, const Lane& lane) {
  std::memcpy(to, &lane, sizeof(Lane));
}
TACTILE_CLAY_INLINE Lane positive(const Lane& a) {
  return a > 0.0f ? a : Lane{};
}
TACTILE_CLAY_INLINE Lane join(const HalfLane& a, const HalfLane& b) {
#if defined(__clang__) || __GNUC__ >= 12
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
#else
  Lane lane;
  std::memcpy(&lane, &a, sizeof a);
  std::memcpy(reinterpret_cast<char*>(&lane) + sizeof a, &b, sizeof b);
  return lane;
#endif
}
TACTILE_CLAY_INLINE HalfLane sumOfHalves(const Lane& a) {
  HalfLane half[2];
  std::memcpy(half, &a, sizeof a);
  return half[0] + half[1];
}
/// Four times lane k, and four times lane k + 4.
/// @tparam k below four
template <int k>
TACTILE_CLAY_INLINE Lane spread(const Lane& a) {
  return TACTILE_CLAY_SHUFFLE(a, a, k, k, k, k, k + 4, k + 4, k + 4, k + 4);
}
TACTILE_CLAY_INLINE Lane root(const Lane& a) {
  Lane result;
  for (int k = 0; k < lane_width; ++k) result[k] = __builtin_sqrtf(a[k]);
  return result;
}

/// Sum of the eight lanes in a fixed order.
TACTILE_CLAY_INLINE float sum(const Lane& a) {
  return ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7]));
}

/// Of a and b, the sums of lanes 0 and 4, 1 and 5, 2 and 6, 3 and 7; those of a come first.
TACTILE_CLAY_INLINE Lane sumHalves(const Lane& a, const Lane& b) {
  return TACTILE_CLAY_SHUFFLE(a, b, 0, 1, 2, 3, 8, 9, 10, 11) +
         TACTILE_CLAY_SHUFFLE(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
}
/// In both halves: the sums of lanes 0 and 2 of a and of b, then of lanes 1 and 3.
TACTILE_CLAY_INLINE Lane sumQuarters(const Lane& a, const Lane& b) {
  return TACTILE_CLAY_SHUFFLE(a, b, 0, 8, 1, 9, 4, 12, 5, 13) +
         TACTILE_CLAY_SHUFFLE(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
}
/// In both halves: the sums of lanes 0 and 2, and 1 and 3, of a, then those of b.
TACTILE_CLAY_INLINE Lane sumPairs(const Lane& a, const Lane& b) {
  return TACTILE_CLAY_SHUFFLE(a, b, 0, 1, 8, 9, 4, 5, 12, 13) +
         TACTILE_CLAY_SHUFFLE(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
}
/// The sums of eight lanes each, with the bits of `sum`.
TACTILE_CLAY_INLINE Lane sums(const Lane (&a)[lane_width]) {
  return sumPairs(sumQuarters(sumHalves(a[0], a[4]), sumHalves(a[1], a[5])),
                  sumQuarters(sumHalves(a[2], a[6]), sumHalves(a[3], a[7])));
}

/// Which lanes, in which order.
using LaneOrder = std::int32_t __attribute__((vector_size(32)));
template <typename L>
TACTILE_CLAY_INLINE L select(const L& a, const LaneOrder& order) {
#if defined(__clang__)
  L result;
  for (int k = 0; k < lane_width; ++k) result[k] = a[order[k]];
  return result;
#else
  return __builtin_shuffle(a, order);
#endif
}
TACTILE_CLAY_INLINE LaneOrder load(const std::uint32_t* from) {
  LaneOrder lane;
  std::memcpy(&lane, from, sizeof lane);
  return lane;
}
TACTILE_CLAY_INLINE void store(std::uint32_t* to, const LaneOrder& lane) {
  std::memcpy(to, &lane, sizeof lane);
}
/// Bit k of the result tells whether a comparison holds in lane k.
TACTILE_CLAY_INLINE unsigned bits(const LaneOrder& holds) {
#if defined(__SSE2__)
  __m128 low, high;
  std::memcpy(&low, &holds, sizeof low);
  std::memcpy(&high, reinterpret_cast<const char*>(&holds) + sizeof low, sizeof high);
  return static_cast<unsigned>(_mm_movemask_ps(low) | _mm_movemask_ps(high) << 4);
#else
  unsigned result = 0;
  for (int k = 0; k < lane_width; ++k) result |= (holds[k] & 1u) << k;
  return result;
#endif
}

/// For each mask of `bits`, the order that brings the lanes that hold to the front; and how many those are.
struct Selections {
  Selections() {
    for (unsigned mask = 0; mask < 256; ++mask) {
      count[mask] = 0;
      for (std::int32_t k = 0; k < lane_width; ++k) {
        order[mask][k] = 0;
        if (mask >> k & 1u) order[mask][count[mask]++] = k;
      }
    }
  }
  LaneOrder order[256];
  std::uint8_t count[256];
};
inline const Selections selections;

/// Three lanes of vectors.
struct LaneVector {
  Lane x, y, z;
};

TACTILE_CLAY_INLINE LaneVector loadVector(const float* x, const float* y, const float* z, std::size_t from) {
  return {load(x + from), load(y + from), load(z + from)};
}
TACTILE_CLAY_INLINE LaneVector difference(const LaneVector& a, const LaneVector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
TACTILE_CLAY_INLINE Lane dot(const LaneVector& a, const LaneVector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
TACTILE_CLAY_INLINE LaneVector times(const Lane& a, const LaneVector& v) {
  return {a * v.x, a * v.y, a * v.z};
}
TACTILE_CLAY_INLINE void add(LaneVector& to, const LaneVector& v) {
  to.x += v.x;
  to.y += v.y;
  to.z += v.z;
}

/// Slots of 16 bytes, of a vector and a fourth number. A slot is named by its first number, 4 i for the slot
/// of particle i, and so is a particle in loops over lanes: no address needs a shift then.
constexpr std::uint32_t slot_size = 4;
TACTILE_CLAY_INLINE HalfLane slot(const float* from) {
  HalfLane h;
  std::memcpy(&h, from, sizeof h);
  return h;
}
TACTILE_CLAY_INLINE void storeSlot(float* to, const HalfLane& h) {
  std::memcpy(to, &h, sizeof h);
}

/// The sums of x, of y, of z and of w, with the bits of `sum`, as a slot.
TACTILE_CLAY_INLINE HalfLane sums(const LaneVector& v, const Lane& w = Lane{}) {
  const Lane halves = sumQuarters(sumHalves(v.x, v.z), sumHalves(v.y, w));
  const Lane slot = sumPairs(halves, halves);
  const Lane low = TACTILE_CLAY_SHUFFLE(slot, slot, 0, 1, 4, 5, 0, 1, 4, 5);
  HalfLane result;
  std::memcpy(&result, &low, sizeof result);
  return result;
}

/// Eight times the same vector.
/// @param slot four floats
TACTILE_CLAY_INLINE LaneVector allOf(const float* slot) {
  HalfLane half;
  std::memcpy(&half, slot, sizeof half);
  const Lane both = join(half, half);
  return {spread<0>(both), spread<1>(both), spread<2>(both)};
}

/// Fetches eight slots.
/// @param w gets the fourth numbers
TACTILE_CLAY_INLINE LaneVector gather(const float* numbers, const std::uint32_t* slots, Lane& w) {
  HalfLane slot[lane_width];
  for (int k = 0; k < lane_width; ++k) std::memcpy(&slot[k], numbers + slots[k], sizeof slot[k]);
  const Lane a = join(slot[0], slot[4]), b = join(slot[1], slot[5]);
  const Lane c = join(slot[2], slot[6]), d = join(slot[3], slot[7]);
  const Lane ab_xy = TACTILE_CLAY_SHUFFLE(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lane ab_zw = TACTILE_CLAY_SHUFFLE(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
  const Lane cd_xy = TACTILE_CLAY_SHUFFLE(c, d, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lane cd_zw = TACTILE_CLAY_SHUFFLE(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
  w = TACTILE_CLAY_SHUFFLE(ab_zw, cd_zw, 2, 3, 10, 11, 6, 7, 14, 15);
  return {TACTILE_CLAY_SHUFFLE(ab_xy, cd_xy, 0, 1, 8, 9, 4, 5, 12, 13),
          TACTILE_CLAY_SHUFFLE(ab_xy, cd_xy, 2, 3, 10, 11, 6, 7, 14, 15),
          TACTILE_CLAY_SHUFFLE(ab_zw, cd_zw, 0, 1, 8, 9, 4, 5, 12, 13)};
}

/// Fetches eight vectors out of such slots.
TACTILE_CLAY_INLINE LaneVector gather(const float* numbers, const std::uint32_t* slots) {
  Lane unused;
  return gather(numbers, slots, unused);
}

/// The opposite: eight vectors into slots that begin every `stride` numbers, with a zero as fourth number
/// each.
TACTILE_CLAY_INLINE void scatter(const LaneVector& v, float* slots, std::size_t stride) {
  const Lane xy_low = TACTILE_CLAY_SHUFFLE(v.x, v.y, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lane xy_high = TACTILE_CLAY_SHUFFLE(v.x, v.y, 2, 10, 3, 11, 6, 14, 7, 15);
  const Lane z_low = TACTILE_CLAY_SHUFFLE(v.z, Lane{}, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lane z_high = TACTILE_CLAY_SHUFFLE(v.z, Lane{}, 2, 10, 3, 11, 6, 14, 7, 15);
  const Lane both[4] = {TACTILE_CLAY_SHUFFLE(xy_low, z_low, 0, 1, 8, 9, 4, 5, 12, 13),
                        TACTILE_CLAY_SHUFFLE(xy_low, z_low, 2, 3, 10, 11, 6, 7, 14, 15),
                        TACTILE_CLAY_SHUFFLE(xy_high, z_high, 0, 1, 8, 9, 4, 5, 12, 13),
                        TACTILE_CLAY_SHUFFLE(xy_high, z_high, 2, 3, 10, 11, 6, 7, 14, 15)};
  for (int k = 0; k < 4; ++k) {
    std::memcpy(slots + stride * k, &both[k], sizeof(HalfLane));
    std::memcpy(slots + stride * (k + 4), reinterpret_cast<const float*>(&both[k]) + 4, sizeof(HalfLane));
  }
}

TACTILE_CLAY_INLINE Lane min(const Lane& a, const Lane& b) {
  return a < b ? a : b;
}
TACTILE_CLAY_INLINE Lane max(const Lane& a, const Lane& b) {
  return a > b ? a : b;
}

/// Fetches the numbers of eight particles, of which there is one each.
/// @param slots of the particles
TACTILE_CLAY_INLINE Lane gatherNumbers(const float* numbers, const std::uint32_t* slots) {
  static_assert(slot_size == sizeof(float), "the slot of a particle is the offset of its number in bytes");
  const char* bytes = reinterpret_cast<const char*>(numbers);
  float of[lane_width];
  for (int k = 0; k < lane_width; ++k) std::memcpy(&of[k], bytes + slots[k], sizeof of[k]);
  return Lane{of[0], of[1], of[2], of[3], of[4], of[5], of[6], of[7]};
}

}  // namespace tactile_clay
