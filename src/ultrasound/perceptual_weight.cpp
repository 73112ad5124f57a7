#include "ultrasound/perceptual_weight.h"

#include <algorithm>
#include <cmath>

namespace tactile_clay::ultrasound {

double perceptualWeight(double pad_distance) {
  constexpr double palm = 58.0 / 241.0;
  constexpr double decay_length = 0.0113;  // m
  if (!std::isfinite(pad_distance)) return palm;
  const double x = std::max(pad_distance - pad_radius, 0.0) / decay_length;
  return palm + (1.0 - palm) / (1.0 + x * x);
}

}  // namespace tactile_clay::ultrasound
