#pragma once

#include <cstdint>
#include <vector>

#include "clay/mesh.h"

namespace tactile_clay::clay {

/// A closed surface of triangles: each edge has two of them.
struct ClosedSurface {
  std::vector<Eigen::Vector3d> vertices;  // m
  std::vector<Mesh::Triangle> triangles;  // all turned outwards, but for those of holes
  std::vector<Eigen::Matrix<std::uint32_t, 3, 1>>
      across;                       // triangle on the other side of the edge from corner k on
  std::vector<std::uint32_t> body;  // of each triangle
  std::uint32_t bodies = 0;
};

/// Joins corners that are the same place, drops triangles that are a line then, and turns all the others
/// outwards.
/// @throws std::invalid_argument with one line where that is no closed surface, or it encloses nothing
ClosedSurface closedSurface(const std::vector<Eigen::Vector3d>& vertices,
                            const std::vector<Mesh::Triangle>& triangles);

/// m^3, signed, of what is closed by triangles that are turned outwards.
double volumeOf(const ClosedSurface& surface);

constexpr double same_place = 1e-6;  // of the diagonal of a mesh; numbers of single precision are 1e-7 apart

}  // namespace tactile_clay::clay
