#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace tactile_clay::scene {

/// A shape to fill with clay, standing on its origin: z from 0 up.
struct Shape {
  enum class Kind { box, cylinder };

  Kind kind = Kind::box;
  Eigen::Vector3d size =
      Eigen::Vector3d::Zero();  // m; box: edges; cylinder: radius below, radius above, height
};

/// Volume of the box that holds the shape, m^3.
double boundingVolume(const Shape& shape);

/// Points of a cubic lattice inside the shape, m, half a spacing off its faces. A box holds the whole number
/// of layers nearest to its edges; a cylinder is filled about its axis.
std::vector<Eigen::Vector3d> latticeIn(const Shape& shape, double spacing);

}  // namespace tactile_clay::scene
