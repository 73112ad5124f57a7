#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace tactile_clay::surface {

/// Corner k of a cell is at (k & 1, k >> 1 & 1, k >> 2 & 1). Edge e runs along axis e / 4, from corner
/// `edge_begin[e]`.
constexpr std::array<std::uint8_t, 12> edge_begin = {0, 2, 4, 6, 0, 1, 4, 5, 0, 1, 2, 3};

/// Triangles within a cell, for each set of corners that are inside (bit k: corner k). Triples of edges,
/// anticlockwise as seen from outside.
///
/// Marching cubes (Lorensen and Cline 1987) whose surface is always a closed manifold. The table is derived,
/// not listed. If a face has two inside corners across from each other, each is cut off separately, in both
/// cells of the face, so that the pieces of the cells fit. The edges on the faces of a cell form polygons.
/// They are cut into triangles so that no cut lies in a face: there it could meet a cut of the neighbouring
/// cell, and four triangles would share it.
class CellPolygons {
 public:
  CellPolygons();
  const std::vector<std::array<std::uint8_t, 3>>& operator[](unsigned inside) const {
    return triangles_[inside];
  }

 private:
  std::array<std::vector<std::array<std::uint8_t, 3>>, 256> triangles_;
};

/// The table, made once.
const CellPolygons& cellPolygons();

}  // namespace tactile_clay::surface
