#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace tactile_clay::surface {

/// Triangles with shared corners.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> position;                // m
  std::vector<Eigen::Vector3f> normal;                  // of each corner, unit, outwards
  std::vector<Eigen::Vector3f> color;                   // of each corner, RGB, 0-1
  std::vector<std::array<std::uint32_t, 3>> triangles;  // corners, anticlockwise as seen from outside
};

/// Volume, m^3, of a closed mesh whose triangles face outwards; negative if they face inwards (divergence
/// theorem).
double volumeOf(const TriangleMesh& mesh);

/// Whether each edge belongs to exactly two triangles, which run along it in opposite directions, and the
/// triangles around each corner are one fan: the surface then has no border and does not touch itself.
bool isClosedManifold(const TriangleMesh& mesh);

/// Sets the normal of each corner: the mean of the normals of the triangles around it, weighted by area.
void setNormals(TriangleMesh& mesh);

}  // namespace tactile_clay::surface
