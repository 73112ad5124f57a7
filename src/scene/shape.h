#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "clay/mesh.h"

namespace tactile_clay::scene {

/// A shape to fill with clay. It stands on its origin, z from 0 up; a mesh lies where its own coordinates
/// say.
struct Shape {
  enum class Kind { box, cylinder, sphere, mesh };

  Kind kind = Kind::box;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // m; box: edges; cylinder: radius below, radius above,
                                                   // height; sphere: radius
  std::shared_ptr<const clay::Mesh> mesh;          // of a mesh, which has its size in itself
};

/// Volume of the box that holds the shape, m^3.
double boundingVolume(const Shape& shape);

/// Points of a cubic lattice inside the shape, m, half a spacing off its faces. A box holds the whole number
/// of layers nearest to its edges; a cylinder is filled about its axis. Spheres and meshes are filled so that
/// the particles have the shape's volume: of the lattices whose middle is a point or lies between points,
/// along each axis, and of surfaces up to 0.15 spacings within or around the shape, those whose volume is
/// nearest to it. What is 6 spacings wide everywhere has its volume within 5 %.
std::vector<Eigen::Vector3d> latticeIn(const Shape& shape, double spacing);

}  // namespace tactile_clay::scene
