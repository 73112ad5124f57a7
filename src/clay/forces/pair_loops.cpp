#include "clay/forces/pair_loops.h"

#include <algorithm>

#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

// Loops get their inputs by value, so that no store can change these.
using Pairs = PairArrays;

/// Prefetches what a loop over many pairs reads some iterations later: the processor itself prefetches only
/// within a page of an array.
template <typename Number>
TACTILE_CLAY_INLINE void fetchAhead(const Pairs& pairs, const Number* numbers, std::uint32_t p) {
  constexpr std::size_t ahead = 256;  // numbers, 1 KiB: time for memory to answer, and still fits the cache
  if (pairs.many) __builtin_prefetch(numbers + p + ahead);
}
TACTILE_CLAY_INLINE LaneVector loadGradient(const Pairs& pairs, std::uint32_t p) {
  fetchAhead(pairs, pairs.slot, p);
  for (const float* along : {pairs.x, pairs.y, pairs.z}) fetchAhead(pairs, along, p);
  return loadVector(pairs.x, pairs.y, pairs.z, p);
}

/// Sets the forces of the springs, the growth of C, or both, of particles [first, last), for each of `count`
/// displacements.
template <bool springs, bool density, int count>
TACTILE_CLAY_INLINE void stretch(const Pairs pairs, const Stretch (&all_of)[count], std::size_t first,
                                 std::size_t last) {
  for (std::size_t i = first; i < last; ++i) {
    LaneVector own[count], forces[count]{};
    Lane total[count]{};
    for (int k = 0; k < count; ++k) own[k] = allOf(all_of[k].u + slot_size * i);
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width) {
      const LaneVector g = loadGradient(pairs, p);
      if (springs) fetchAhead(pairs, pairs.spring, p);
      for (int k = 0; k < count; ++k) {
        const Lane along = dot(g, difference(gather(all_of[k].u, pairs.slot + p), own[k]));
        if (density) total[k] += along;
        if (springs) add(forces[k], times(load(pairs.spring + p) * along, g));
      }
    }
    for (int k = 0; k < count; ++k) {
      HalfLane both = sums(forces[k], total[k]);
      if (density) all_of[k].growth[i] = both[3];
      both[3] = 0.0f;
      storeSlot(all_of[k].f + slot_size * i, both);
    }
  }
}
TACTILE_CLAY_MULTIVERSION
void stretchSprings(const Pairs pairs, const Stretch one, std::size_t first, std::size_t last) {
  stretch<true, false>(pairs, {one}, first, last);
}
TACTILE_CLAY_MULTIVERSION
void stretchDensity(const Pairs pairs, const Stretch one, std::size_t first, std::size_t last) {
  stretch<false, true>(pairs, {one}, first, last);
}
TACTILE_CLAY_MULTIVERSION
void stretchBoth(const Pairs pairs, const Stretch one, std::size_t first, std::size_t last) {
  stretch<true, true>(pairs, {one}, first, last);
}
TACTILE_CLAY_MULTIVERSION
void stretchBothTwice(const Pairs pairs, const Stretch one, const Stretch other, std::size_t first,
                      std::size_t last) {
  stretch<true, true>(pairs, {one, other}, first, last);
}

/// Adds the forces of `count` sets of pressures. `squeezed` marks the particles with any; if `find`, it is
/// set here, by the first set.
template <bool find, int count, typename Flags>
TACTILE_CLAY_INLINE void press(const Pairs pairs, const Press (&all_of)[count], std::size_t first,
                               std::size_t last, Flags* squeezed) {
  for (std::size_t i = first; i < last; ++i) {
    if (!find && squeezed[i] == 0) continue;
    Lane own[count];
    LaneVector forces[count]{};
    for (int k = 0; k < count; ++k) own[k] = all(all_of[k].pressure[i]);
    Lane maximum = own[0];
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width) {
      const LaneVector g = loadGradient(pairs, p);
      for (int k = 0; k < count; ++k) {
        const Lane of_others = gatherNumbers(all_of[k].pressure, pairs.slot + p);
        if (find && k == 0) maximum = maximum > of_others ? maximum : of_others;
        add(forces[k], times(own[k] + of_others, g));
      }
    }
    if constexpr (find) squeezed[i] = bits(maximum > 0.0f) != 0;
    for (int k = 0; k < count; ++k) {
      float* f = all_of[k].f + slot_size * i;
      storeSlot(f, slot(f) + sums(forces[k]));
    }
  }
}
TACTILE_CLAY_MULTIVERSION
void findPressed(const Pairs pairs, const Press one, std::size_t first, std::size_t last,
                 std::uint8_t* squeezed) {
  press<true>(pairs, {one}, first, last, squeezed);
}
TACTILE_CLAY_MULTIVERSION
void findPressedTwice(const Pairs pairs, const Press one, const Press other, std::size_t first,
                      std::size_t last, std::uint8_t* squeezed) {
  press<true>(pairs, {one, other}, first, last, squeezed);
}
TACTILE_CLAY_MULTIVERSION
void pressSqueezed(const Pairs pairs, const Press one, std::size_t first, std::size_t last,
                   const std::uint8_t* squeezed) {
  press<false>(pairs, {one}, first, last, squeezed);
}

}  // namespace

void stretchPairs(const PairArrays& pairs, const Stretch& one, std::size_t first, std::size_t last) {
  if (pairs.sprung && pairs.dense)
    stretchBoth(pairs, one, first, last);
  else if (pairs.sprung)
    stretchSprings(pairs, one, first, last);
  else if (pairs.dense)
    stretchDensity(pairs, one, first, last);
  else
    std::fill(one.f + slot_size * first, one.f + slot_size * last, 0.0f);
}

void stretchPairs(const PairArrays& pairs, const Stretch& one, const Stretch& other, std::size_t first,
                  std::size_t last) {
  if (pairs.sprung && pairs.dense) return stretchBothTwice(pairs, one, other, first, last);
  stretchPairs(pairs, one, first, last);
  stretchPairs(pairs, other, first, last);
}

void Pressing::add(std::size_t first, std::size_t last) const {
  if (!any) return;
  if (!finds)
    pressSqueezed(pairs, one, first, last, squeezed);
  else if (other.f == nullptr)
    findPressed(pairs, one, first, last, squeezed);
  else
    findPressedTwice(pairs, one, other, first, last, squeezed);
}

}  // namespace tactile_clay::clay
