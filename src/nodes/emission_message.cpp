#include "nodes/emission_message.h"

#include <tf2_eigen/tf2_eigen.h>

#include <limits>

#include "nodes/conversions.h"

namespace tactile_clay::nodes {

device::Emission emissionOf(const FocalPointArray& message) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  device::Emission emission;
  emission.points = toCore(message.points);
  for (std::size_t k = 0; k < emission.points.size() && !message.weight.empty(); ++k)
    emission.points[k].weight = k < message.weight.size() ? message.weight[k] : unknown;
  for (std::size_t k = 0; k < emission.points.size() && !message.normal.empty(); ++k) {
    Eigen::Vector3d& normal = emission.points[k].normal;
    normal.setConstant(unknown);
    if (k < message.normal.size()) tf2::fromMsg(message.normal[k], normal);
  }
  emission.modulation_frequency = message.modulation_frequency;
  emission.modulation = static_cast<ultrasound::Modulation>(message.modulation);
  emission.slip = message.slip;
  return emission;
}

}  // namespace tactile_clay::nodes
