#include "surface/cut_mesh.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace tactile_clay::surface {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// Adds the corner on an edge at which the value is 0. An edge gives the same place from both sides.
std::uint32_t addCorner(TriangleMesh& mesh, const std::vector<float>& value, std::uint32_t a,
                        std::uint32_t b) {
  if (a > b) std::swap(a, b);
  const float t = value[a] / (value[a] - value[b]);
  mesh.position.push_back(mesh.position[a] + t * (mesh.position[b] - mesh.position[a]));
  mesh.normal.push_back((mesh.normal[a] + t * (mesh.normal[b] - mesh.normal[a])).normalized());
  mesh.color.push_back(mesh.color[a] + t * (mesh.color[b] - mesh.color[a]));
  return static_cast<std::uint32_t>(mesh.position.size() - 1);
}

/// Adds the parts of a triangle of which only the first corner lies on one side.
void cutOff(TriangleMesh& mesh, const std::vector<float>& value, const std::array<std::uint32_t, 3>& t,
            Triangles& tip, Triangles& rest) {
  const std::uint32_t ab = addCorner(mesh, value, t[0], t[1]), ca = addCorner(mesh, value, t[2], t[0]);
  tip.push_back({t[0], ab, ca});
  rest.push_back({ab, t[1], t[2]});
  rest.push_back({ab, t[2], ca});
}

}  // namespace

CutMesh cut(const TriangleMesh& mesh, const std::vector<float>& value) {
  if (value.size() != mesh.position.size() || mesh.color.size() != mesh.position.size())
    throw std::invalid_argument(std::to_string(value.size()) + " values and " +
                                std::to_string(mesh.color.size()) + " colours of " +
                                std::to_string(mesh.position.size()) + " corners: expected one each");
  CutMesh parts;
  parts.mesh.position = mesh.position;
  parts.mesh.normal = mesh.normal;
  parts.mesh.color = mesh.color;
  for (const auto& t : mesh.triangles) {
    const auto isLow = [&](std::size_t k) { return value[t[k % 3]] < 0.0f; };
    const int lows = isLow(0) + isLow(1) + isLow(2);
    if (lows == 0 || lows == 3) {
      (lows == 3 ? parts.low : parts.high).push_back(t);
      continue;
    }
    std::size_t alone = 0;
    while (isLow(alone) != (lows == 1)) ++alone;
    Triangles &tip = lows == 1 ? parts.low : parts.high, &rest = lows == 1 ? parts.high : parts.low;
    cutOff(parts.mesh, value, {t[alone], t[(alone + 1) % 3], t[(alone + 2) % 3]}, tip, rest);
  }
  return parts;
}

}  // namespace tactile_clay::surface
