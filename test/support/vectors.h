#pragma once

#include <Eigen/Core>
#include <vector>

#include "clay/vector_field.h"

namespace tactile_clay::clay {

using Vectors = std::vector<Eigen::Vector3d>;

inline Vectors toVectors(const VectorField& field) {
  Vectors all;
  for (std::size_t i = 0; i < field.size(); ++i) all.push_back(field.at(i).cast<double>());
  return all;
}

}  // namespace tactile_clay::clay
