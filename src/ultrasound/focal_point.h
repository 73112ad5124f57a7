#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace tactile_clay::ultrasound {

/// A focal point commanded to the array, in the frame of the array.
struct FocalPoint {
  std::uint32_t id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // m
  double pressure = 0.0;                               // Pa of the clay's pressure field (Eq. 9)
  double intensity = 0.0;                              // 0-1, amplitude over what the array can give
  double weight = 1.0;                                 // 0 or more, of its error in a field
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();    // of the skin of a field, outward; 0: not known
};

}  // namespace tactile_clay::ultrasound
