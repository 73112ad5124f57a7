#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "surface/triangle_mesh.h"

namespace tactile_clay::surface {

/// A mesh in two parts, which meet in a line that runs through triangles.
struct CutMesh {
  TriangleMesh mesh;                                    // all corners, and the triangles of neither part
  std::vector<std::array<std::uint32_t, 3>> low, high;  // triangles where the value is below 0, and above
};

/// Cuts a mesh where a value that is linear along edges is 0. Corners on the line get the mean position,
/// normal and colour of the ends of their edge, by distance.
/// @param mesh with n corners, and a colour for each
/// @param value of each of the n corners, finite
/// @throws std::invalid_argument where there is not one value and one colour a corner
CutMesh cut(const TriangleMesh& mesh, const std::vector<float>& value);

}  // namespace tactile_clay::surface
