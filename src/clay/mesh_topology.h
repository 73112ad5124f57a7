#pragma once

#include <cstdint>
#include <vector>

#include "clay/mesh.h"

namespace tactile_clay::clay {

/// A closed surface of triangles: each edge belongs to two triangles.
struct ClosedSurface {
  std::vector<Eigen::Vector3d> vertices;  // m
  std::vector<Mesh::Triangle> triangles;  // all turned outwards, except those of holes
  /// Of each triangle: the triangles on the other side of its edges; edge k begins at corner k.
  std::vector<Eigen::Matrix<std::uint32_t, 3, 1>> across;
  std::vector<std::uint32_t> body;  // of each triangle
  std::uint32_t bodies = 0;
};

/// Joins corners at the same place, drops triangles that then are a line, and turns all others outwards,
/// except those of holes.
/// @throws std::invalid_argument with one line if the surface is not closed, or encloses nothing
ClosedSurface closedSurface(const std::vector<Eigen::Vector3d>& vertices,
                            const std::vector<Mesh::Triangle>& triangles);

/// Volume that the triangles enclose, m^3; positive if they are turned outwards.
double volumeOf(const ClosedSurface& surface);

constexpr double same_place = 1e-6;  // of the diagonal of a mesh; single precision resolves 1e-7

}  // namespace tactile_clay::clay
