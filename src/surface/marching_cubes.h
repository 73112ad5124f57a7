#pragma once

#include <cstdint>
#include <vector>

#include "surface/field_grid.h"
#include "surface/triangle_mesh.h"

namespace tactile_clay::surface {

/// Appends the surface where the field has a level, which must be positive: a closed manifold (class
/// CellPolygons), with what is above the level inside. Sets positions and triangles only.
/// @param grid whose `corner` is none on all edges, as after FieldGrid::update; it is used up
/// @param block_of gets the block of the grid that each corner is in
void march(FieldGrid& grid, float level, TriangleMesh& mesh, std::vector<std::uint32_t>& block_of);

}  // namespace tactile_clay::surface
