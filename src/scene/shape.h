#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "clay/mesh.h"

namespace tactile_clay::scene {

/// A shape to fill with clay. It stands on its origin, z from 0 up; a mesh lies at its own coordinates.
struct Shape {
  enum class Kind { box, cylinder, sphere, mesh };

  Kind kind = Kind::box;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // m; box: edges; cylinder: radius below, radius above,
                                                   // height; sphere: radius
  std::shared_ptr<const clay::Mesh> mesh;          // of a mesh, which has no `size`
};

/// Edges of the box around the shape, m.
Eigen::Vector3d extentsOf(const Shape& shape);

/// Number of cells of a lattice in the box around the shape, which has at least one layer along each axis.
double cellsAround(const Shape& shape, double spacing);

/// Points of a cubic lattice inside the shape, m, half a spacing off its faces. In a box the number of layers
/// is the whole number nearest to its edges. A cylinder is filled about its axis. Spheres and meshes are
/// filled so that the particles have the volume of the shape. For this, lattices are tried whose middle,
/// along each axis, is a point or lies between two points, and surfaces up to 0.15 spacings inside or outside
/// of the shape. The lattice and surface with the volume nearest to the shape's are taken. A shape that is at
/// least 6 spacings wide everywhere gets its volume within 5 %.
std::vector<Eigen::Vector3d> latticeIn(const Shape& shape, double spacing);

}  // namespace tactile_clay::scene
