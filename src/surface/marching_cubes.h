#pragma once

#include <cstdint>
#include <vector>

#include "surface/field_grid.h"
#include "surface/triangle_mesh.h"

namespace tactile_clay::surface {

/// Appends the surface at a level of the field, which must be positive: a closed manifold (class
/// CellPolygons) around the places above the level. Sets positions and triangles only.
/// @param grid its `corner` is none on all edges, as after FieldGrid::update; this call fills it
/// @param block_of receives the block of the grid in which each corner is
void march(FieldGrid& grid, float level, TriangleMesh& mesh, std::vector<std::uint32_t>& block_of);

}  // namespace tactile_clay::surface
