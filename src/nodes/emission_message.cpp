#include "nodes/emission_message.h"

#include <limits>

#include "nodes/conversions.h"

namespace tactile_clay::nodes {

device::Emission emissionOf(const FocalPointArray& message) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  device::Emission emission;
  emission.points = toCore(message.points);
  for (std::size_t k = 0; k < emission.points.size() && !message.weight.empty(); ++k)
    emission.points[k].weight = k < message.weight.size() ? message.weight[k] : unknown;
  emission.modulation_frequency = message.modulation_frequency;
  emission.modulation = static_cast<ultrasound::Modulation>(message.modulation);
  emission.slip = message.slip;
  return emission;
}

}  // namespace tactile_clay::nodes
