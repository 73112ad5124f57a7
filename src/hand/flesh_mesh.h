#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "hand/capsule.h"

namespace tactile_clay::hand {

/// Tetrahedra that fill a body, and the triangles of its surface, wound so that normals point outward.
struct FleshMesh {
  std::vector<Eigen::Vector3d> nodes;          // m
  std::vector<std::array<int, 4>> tetrahedra;  // positive volume
  std::vector<std::array<int, 3>> triangles;
};

double volume(const FleshMesh& mesh, const std::array<int, 4>& tetrahedron);  // m^3, signed

/// Fills the union of capsules, with its surface nodes on the union's surface: a body-centred cubic lattice
/// of tetrahedra is cut at the surface, after nodes near it were moved onto it so that no piece is too small
/// (isosurface stuffing, Labelle & Shewchuk 2007). The same arguments give the same mesh.
/// @param cell edge of the lattice's cube, m; 12 tetrahedra each
/// @throws std::invalid_argument if it is not positive or no node is inside
FleshMesh fillCapsules(const std::vector<Capsule>& capsules, double cell);

}  // namespace tactile_clay::hand
