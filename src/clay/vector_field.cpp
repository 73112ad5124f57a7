#include "clay/vector_field.h"

#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

using DoubleLane = double __attribute__((vector_size(32)));

TACTILE_CLAY_INLINE DoubleLane product(const float* a, const float* b) {
  return __builtin_convertvector(slot(a) * slot(b), DoubleLane);
}
TACTILE_CLAY_MULTIVERSION
double dotOfSlots(const float* a, const float* b, std::size_t count) {
  DoubleLane even{}, odd{};  // two sums, so that no addition waits for the other
  std::size_t k = 0;
  for (; k + 2 * slot_size <= count; k += 2 * slot_size) {
    even += product(a + k, b + k);
    odd += product(a + k + slot_size, b + k + slot_size);
  }
  if (k < count) even += product(a + k, b + k);
  const DoubleLane sum = even + odd;
  return (sum[0] + sum[1]) + sum[2];
}

}  // namespace

double dot(const VectorField& a, const VectorField& b, std::size_t first, std::size_t last) {
  return dotOfSlots(a.data() + slot_size * first, b.data() + slot_size * first, slot_size * (last - first));
}

}  // namespace tactile_clay::clay
