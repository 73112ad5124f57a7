#include "surface/marching_cubes.h"

#include <algorithm>

#include "surface/cell_polygons.h"

namespace tactile_clay::surface {
namespace {

// Corners keep this distance from the nodes, as a share of a cell, so that no two are at the same place.
constexpr float min_share = 1e-3f;

}  // namespace

void march(FieldGrid& grid, float level, TriangleMesh& mesh, std::vector<std::uint32_t>& block_of) {
  constexpr int size = FieldGrid::block_size, row = FieldGrid::row_size;
  const CellPolygons& polygons = cellPolygons();
  std::vector<FieldGrid::Block>& blocks = grid.blocks();
  const float edge = grid.cell();
  for (std::uint32_t b = 0; b < blocks.size(); ++b) {
    const FieldGrid::Block& block = blocks[b];
    /// Corner of the mesh on edge e of cell (x, y, z).
    const auto cornerOn = [&](unsigned e, int x, int y, int z) {
      const unsigned first = edge_begin[e], axis = e / 4;
      int n[3] = {x + static_cast<int>(first & 1), y + static_cast<int>(first >> 1 & 1),
                  z + static_cast<int>(first >> 2)};
      const int in_row = (n[2] * row + n[1]) * row + n[0];
      unsigned beyond = 0;
      for (unsigned a = 0; a < 3; ++a)
        if (n[a] == size) {
          beyond |= 1u << a;
          n[a] = 0;
        }
      const std::uint32_t owner = block.next[beyond];
      std::uint32_t& corner = blocks[owner].corner[axis][(n[2] * size + n[1]) * size + n[0]];
      if (corner != FieldGrid::none) return corner;
      corner = static_cast<std::uint32_t>(mesh.position.size());
      const float from = block.value[in_row], to = block.value[in_row + (axis == 0   ? 1
                                                                         : axis == 1 ? row
                                                                                     : row * row)];
      Eigen::Vector3f at = (size * blocks[owner].at + Eigen::Vector3i(n[0], n[1], n[2])).cast<float>();
      at[axis] += std::clamp((level - from) / (to - from), min_share, 1.0f - min_share);
      mesh.position.push_back(edge * (at.array() + FieldGrid::first_node).matrix());
      block_of.push_back(owner);
      return corner;
    };
    for (int z = 0; z < size; ++z) {
      for (int y = 0; y < size; ++y) {
        const float* const at = &block.value[(z * row + y) * row];
        unsigned in[4], any = 0, every = ~0u;  // bit x: node x of the row is inside
        for (int k = 0; k < 4; ++k) {
          const float* const nodes = at + ((k >> 1) * row + (k & 1)) * row;
          in[k] = bits(load(nodes) > all(level)) | (nodes[size] > level ? 1u << size : 0u);
          any |= in[k];
          every &= in[k];
        }
        if (any == 0 || every == (2u << size) - 1) continue;
        for (int x = 0; x < size; ++x) {
          unsigned inside = 0;
          for (int k = 0; k < 4; ++k) inside |= (in[k] >> x & 3u) << 2 * k;
          for (const auto& t : polygons[inside])
            mesh.triangles.push_back(
                {cornerOn(t[0], x, y, z), cornerOn(t[1], x, y, z), cornerOn(t[2], x, y, z)});
        }
      }
    }
  }
}

}  // namespace tactile_clay::surface
