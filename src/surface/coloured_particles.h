#pragma once

#include <Eigen/Core>
#include <vector>

#include "clay/vector_field.h"

namespace tactile_clay::surface {

/// Particles that a picture of the clay can show.
struct ColouredParticles {
  clay::VectorField position;          // m, n of them, each within a kilometre of the origin
  std::vector<Eigen::Vector3f> color;  // RGB, 0-1, n of them

  /// Takes those of n particles that are finite and within a kilometre of the origin, in their order.
  /// @param from m
  /// @param colors RGB, 0-1, of each
  /// @throws std::invalid_argument where there is not one colour a particle
  void take(const clay::VectorField& from, const std::vector<Eigen::Vector3f>& colors);
};

}  // namespace tactile_clay::surface
