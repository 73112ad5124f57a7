#include "clay/vector_field.h"

#include "clay/lanes.h"

namespace tactile_clay::clay {
namespace {

using DoubleLane = double __attribute__((vector_size(32)));

TACTILE_CLAY_MULTIVERSION
double dotOfSlots(const float* a, const float* b, std::size_t first, std::size_t last) {
  DoubleLane sums[2] = {};  // in turns, so that none waits for the other
  for (std::size_t i = first; i < last; ++i)
    sums[i % 2] += __builtin_convertvector(slot(a + slot_size * i) * slot(b + slot_size * i), DoubleLane);
  const DoubleLane sum = sums[0] + sums[1];
  return (sum[0] + sum[1]) + sum[2];
}

}  // namespace

double dot(const VectorField& a, const VectorField& b, std::size_t first, std::size_t last) {
  return dotOfSlots(a.data(), b.data(), first, last);
}

}  // namespace tactile_clay::clay
