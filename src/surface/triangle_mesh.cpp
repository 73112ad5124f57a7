#include "surface/triangle_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace tactile_clay::surface {

double volumeOf(const TriangleMesh& mesh) {
  // About a corner of the mesh: far from the origin the terms would cancel.
  const Eigen::Vector3d about =
      mesh.position.empty() ? Eigen::Vector3d::Zero().eval() : mesh.position[0].cast<double>().eval();
  double volume = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d p = mesh.position[a].cast<double>() - about;
    const Eigen::Vector3d q = mesh.position[b].cast<double>() - about;
    const Eigen::Vector3d r = mesh.position[c].cast<double>() - about;
    volume += p.dot(q.cross(r)) / 6.0;
  }
  return volume;
}

bool isClosedManifold(const TriangleMesh& mesh) {
  // For each corner of a triangle: from the next corner to the corner before.
  struct Turn {
    std::uint32_t corner, from, to;
  };
  std::vector<Turn> turns;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      if (t[k] >= mesh.position.size() || t[k] == t[(k + 1) % 3]) return false;
      turns.push_back({t[k], t[(k + 1) % 3], t[(k + 2) % 3]});
    }
  }
  std::sort(turns.begin(), turns.end(), [](const Turn& a, const Turn& b) {
    return a.corner != b.corner ? a.corner < b.corner : a.from < b.from;
  });
  for (std::size_t begin = 0, end = 0; begin < turns.size(); begin = end) {
    while (end < turns.size() && turns[end].corner == turns[begin].corner) ++end;
    // One cycle must pass all of them: each edge is left once and reached once.
    std::size_t visited = 0;
    std::uint32_t at = turns[begin].from;
    do {
      const auto next =
          std::lower_bound(turns.begin() + begin, turns.begin() + end, at,
                           [](const Turn& turn, std::uint32_t from) { return turn.from < from; });
      if (next == turns.begin() + end || next->from != at) return false;
      at = next->to;
      ++visited;
    } while (at != turns[begin].from && visited <= end - begin);
    if (visited != end - begin) return false;
  }
  return true;
}

void setNormals(TriangleMesh& mesh) {
  mesh.normal.assign(mesh.position.size(), Eigen::Vector3f::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3f across =
        (mesh.position[b] - mesh.position[a]).cross(mesh.position[c] - mesh.position[a]);
    for (const std::uint32_t corner : {a, b, c}) mesh.normal[corner] += across;
  }
  for (Eigen::Vector3f& normal : mesh.normal) {
    const float length = normal.norm();
    normal = length > 0.0f ? Eigen::Vector3f(normal / length) : Eigen::Vector3f::UnitZ();
  }
}

}  // namespace tactile_clay::surface
