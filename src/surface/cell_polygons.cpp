#include "surface/cell_polygons.h"

#include <algorithm>
#include <optional>
#include <stdexcept>

namespace tactile_clay::surface {
namespace {

using Triangle = std::array<std::uint8_t, 3>;

unsigned edgeBetween(unsigned a, unsigned b) {
  const unsigned axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2, low = std::min(a, b);
  for (unsigned e = 4 * axis; e < 4 * axis + 4; ++e)
    if (edge_begin[e] == low) return e;
  throw std::logic_error("corners of a cell that no edge joins");
}

/// Corners of the faces, anticlockwise as seen from outside of the cell.
std::array<std::array<unsigned, 4>, 6> faces() {
  std::array<std::array<unsigned, 4>, 6> all;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const unsigned n = 1u << axis, u = 1u << (axis + 1) % 3, v = 1u << (axis + 2) % 3;
    all[2 * axis] = {0, v, u | v, u};
    all[2 * axis + 1] = {n, n | u, n | u | v, n | v};
  }
  return all;
}

/// Whether a face of the cell contains both edges.
bool shareFace(unsigned a, unsigned b) {
  for (unsigned axis = 0; axis < 3; ++axis)
    if (a / 4 != axis && b / 4 != axis && (edge_begin[a] >> axis & 1) == (edge_begin[b] >> axis & 1))
      return true;
  return false;
}

/// Cuts polygon [first, last] of `loop`, whose side from last to first exists already, into triangles.
bool cut(const std::vector<unsigned>& loop, std::size_t first, std::size_t last,
         std::vector<Triangle>& triangles) {
  if (last - first < 2) return true;
  const auto allowed = [&](std::size_t a, std::size_t b) {
    return b - a == 1 || b - a == loop.size() - 1 || !shareFace(loop[a], loop[b]);
  };
  for (std::size_t k = first + 1; k < last; ++k) {
    if (!allowed(first, k) || !allowed(k, last)) continue;
    const std::size_t before = triangles.size();
    triangles.push_back({static_cast<std::uint8_t>(loop[first]), static_cast<std::uint8_t>(loop[k]),
                         static_cast<std::uint8_t>(loop[last])});
    if (cut(loop, first, k, triangles) && cut(loop, k, last, triangles)) return true;
    triangles.resize(before);
  }
  return false;
}

std::vector<Triangle> trianglesOf(unsigned inside) {
  // On each face, along its border anticlockwise, the surface comes in at the edge where the border enters
  // the clay, and goes out at the next edge where it leaves the clay. Where it goes out of one face, it comes
  // into the next face.
  std::array<std::optional<unsigned>, 12> next;
  for (const auto& face : faces()) {
    for (unsigned k = 0; k < 4; ++k) {
      const auto in = [&](unsigned corner) { return inside >> face[corner % 4] & 1; };
      if (in(k) || !in(k + 1)) continue;
      unsigned to = k + 1;
      while (in(to + 1)) ++to;
      next[edgeBetween(face[k], face[(k + 1) % 4])] = edgeBetween(face[to % 4], face[(to + 1) % 4]);
    }
  }
  std::vector<Triangle> triangles;
  for (unsigned start = 0; start < 12; ++start) {
    std::vector<unsigned> loop;
    for (unsigned at = start; next[at];) {
      loop.push_back(at);
      const unsigned to = *next[at];
      next[at].reset();
      at = to;
    }
    if (!loop.empty() && !cut(loop, 0, loop.size() - 1, triangles))
      throw std::logic_error("a polygon of a cell that cannot be cut");
  }
  return triangles;
}

}  // namespace

CellPolygons::CellPolygons() {
  for (unsigned inside = 0; inside < 256; ++inside) triangles_[inside] = trianglesOf(inside);
}

const CellPolygons& cellPolygons() {
  static const CellPolygons polygons;
  return polygons;
}

}  // namespace tactile_clay::surface
