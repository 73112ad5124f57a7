#include "hand/flesh_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// A node moves onto the surface if an edge is cut nearer to it than this share of the edge.
constexpr double snap = 0.3;

// The lattice has nodes at whole and at half coordinates. Counted in half cells, the coordinates of a node
// are all even or all odd.
class Stuffing {
 public:
  Stuffing(const std::vector<Capsule>& capsules, double cell) : capsules_(capsules), half_(0.5 * cell) {
    Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const Capsule& c : capsules) {
      for (const auto& [centre, r] : {std::pair{c.from, c.radius_from}, std::pair{c.to, c.radius_to}}) {
        low = low.cwiseMin(centre - Vector3d::Constant(r));
        high = high.cwiseMax(centre + Vector3d::Constant(r));
      }
    }
    low_ = (low / cell).array().floor().cast<int>() - 1;
    high_ = (high / cell).array().ceil().cast<int>() + 1;
  }

  FleshMesh fill() {
    forEachTetrahedron([&](const std::array<int, 4>& t) {
      bool inside = false;
      for (const int n : t) inside = inside || value_[n] < 0.0;
      if (inside) cells_.push_back(t);
    });
    snapNodes();
    for (const std::array<int, 4>& t : cells_) clip(t);
    compact();
    findSurface();
    return std::move(mesh_);
  }

 private:
  int node(const Vector3i& at) {
    const auto [found, fresh] = index_.try_emplace({at.x(), at.y(), at.z()}, static_cast<int>(value_.size()));
    if (fresh) {
      mesh_.nodes.push_back(half_ * at.cast<double>());
      value_.push_back(distanceToUnion(capsules_, mesh_.nodes.back()));
    }
    return found->second;
  }

  // Around each edge between the centres of two neighbouring cubes stand four tetrahedra, one for each edge
  // of the square that the cubes share.
  template <typename Visitor>
  void forEachTetrahedron(const Visitor& visit) {
    for (int z = low_.z(); z <= high_.z(); ++z)
      for (int y = low_.y(); y <= high_.y(); ++y)
        for (int x = low_.x(); x <= high_.x(); ++x)
          for (int axis = 0; axis < 3; ++axis) {
            const Vector3i centre = 2 * Vector3i(x, y, z) + Vector3i::Ones();
            const Vector3i step = 2 * Vector3i::Unit(axis);
            const Vector3i u = Vector3i::Unit((axis + 1) % 3), v = Vector3i::Unit((axis + 2) % 3);
            const Vector3i middle = centre + Vector3i::Unit(axis);
            const std::array<Vector3i, 4> square = {middle - u - v, middle + u - v, middle + u + v,
                                                    middle - u + v};
            for (int k = 0; k < 4; ++k)
              visit({node(centre), node(centre + step), node(square[k]), node(square[(k + 1) % 4])});
          }
  }

  // Share of the edge from a to b at which the surface is crossed, by bisection.
  double crossing(int a, int b) const {
    double inside = value_[a] < 0.0 ? 0.0 : 1.0, outside = 1.0 - inside;
    for (int i = 0; i < 30; ++i) {
      const double middle = 0.5 * (inside + outside);
      const Vector3d x = mesh_.nodes[a] + middle * (mesh_.nodes[b] - mesh_.nodes[a]);
      (distanceToUnion(capsules_, x) < 0.0 ? inside : outside) = middle;
    }
    return 0.5 * (inside + outside);
  }

  void snapNodes() {
    struct Snap {
      double share = snap;
      Vector3d to;
    };
    std::vector<Snap> snaps(value_.size());
    std::set<std::pair<int, int>> seen;  // an edge is part of many tetrahedra
    for (const std::array<int, 4>& t : cells_)
      for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 4; ++k) {
          const int a = t[i], b = t[k];
          if ((value_[a] < 0.0) == (value_[b] < 0.0) || !seen.insert({a, b}).second) continue;
          const double share = crossing(a, b);
          if (share < snaps[a].share)
            snaps[a] = {share, mesh_.nodes[a] + share * (mesh_.nodes[b] - mesh_.nodes[a])};
        }
    for (std::size_t n = 0; n < snaps.size(); ++n)
      if (snaps[n].share < snap) {
        mesh_.nodes[n] = snaps[n].to;
        value_[n] = 0.0;
      }
  }

  int cut(int inside, int outside) {
    const auto [found, fresh] = cuts_.try_emplace({inside, outside}, 0);
    if (fresh) {
      const double share = crossing(inside, outside);
      found->second = static_cast<int>(mesh_.nodes.size());
      mesh_.nodes.push_back(mesh_.nodes[inside] + share * (mesh_.nodes[outside] - mesh_.nodes[inside]));
    }
    return found->second;
  }

  void add(std::array<int, 4> t) {
    const double v = volume(mesh_, t);
    if (v < 0.0) std::swap(t[2], t[3]);
    if (std::abs(v) > 1e-3 * half_ * half_ * half_) mesh_.tetrahedra.push_back(t);
  }
  // A prism with the ends a and b. Each side is split at its lowest node, so neighbours agree and the splits
  // never form a circle.
  void addPrism(std::array<int, 3> a, std::array<int, 3> b) {
    // Turned so that the lowest node of all is a[0].
    int lowest = 0;
    for (int i = 0; i < 6; ++i) {
      const auto at = [&](int k) { return k < 3 ? a[k] : b[k - 3]; };
      if (at(i) < at(lowest)) lowest = i;
    }
    if (lowest >= 3) std::swap(a, b);
    std::rotate(a.begin(), a.begin() + lowest % 3, a.end());
    std::rotate(b.begin(), b.begin() + lowest % 3, b.end());
    add({a[0], b[0], b[1], b[2]});
    if (std::min(a[1], b[2]) < std::min(a[2], b[1])) {  // diagonal from a[1] to b[2]
      add({a[0], a[1], b[1], b[2]});
      add({a[0], a[1], b[2], a[2]});
    } else {
      add({a[0], a[1], b[1], a[2]});
      add({a[0], a[2], b[1], b[2]});
    }
  }
  void addPyramid(int apex, std::array<int, 4> base) {
    std::rotate(base.begin(), std::min_element(base.begin(), base.end()), base.end());
    add({apex, base[0], base[1], base[2]});
    add({apex, base[0], base[2], base[3]});
  }

  // The inner part of one lattice tetrahedron.
  void clip(const std::array<int, 4>& t) {
    std::vector<int> in, on, out;
    for (const int n : t) (value_[n] < 0.0 ? in : value_[n] > 0.0 ? out : on).push_back(n);
    if (in.empty()) return;
    if (out.empty()) {
      add(t);
    } else if (in.size() == 1) {
      std::vector<int> corners = in;
      corners.insert(corners.end(), on.begin(), on.end());
      for (const int n : out) corners.push_back(cut(in[0], n));
      add({corners[0], corners[1], corners[2], corners[3]});
    } else if (in.size() == 3) {
      const int d = out[0];
      addPrism({in[0], in[1], in[2]}, {cut(in[0], d), cut(in[1], d), cut(in[2], d)});
    } else if (on.size() == 1) {
      addPyramid(on[0], {in[0], in[1], cut(in[1], out[0]), cut(in[0], out[0])});
    } else {
      addPrism({in[0], cut(in[0], out[0]), cut(in[0], out[1])},
               {in[1], cut(in[1], out[0]), cut(in[1], out[1])});
    }
  }

  // Removes nodes that belong to no tetrahedron; the order stays.
  void compact() {
    std::vector<int> renamed(mesh_.nodes.size(), -1);
    for (const auto& t : mesh_.tetrahedra)
      for (const int n : t) renamed[n] = 0;
    std::vector<Vector3d> kept;
    for (std::size_t n = 0; n < renamed.size(); ++n)
      if (renamed[n] == 0) {
        renamed[n] = static_cast<int>(kept.size());
        kept.push_back(mesh_.nodes[n]);
      }
    for (auto& t : mesh_.tetrahedra)
      for (int& n : t) n = renamed[n];
    mesh_.nodes = std::move(kept);
  }

  void findSurface() {
    static constexpr int faces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
    std::map<std::array<int, 3>, std::pair<std::array<int, 3>, int>> count;
    for (const auto& t : mesh_.tetrahedra)
      for (const auto& face : faces) {
        const std::array<int, 3> triangle = {t[face[0]], t[face[1]], t[face[2]]};
        std::array<int, 3> key = triangle;
        std::sort(key.begin(), key.end());
        ++count.try_emplace(key, triangle, 0).first->second.second;
      }
    for (const auto& [key, found] : count)
      if (found.second == 1) mesh_.triangles.push_back(found.first);
  }

  std::vector<Capsule> capsules_;
  double half_;
  Vector3i low_, high_;
  std::map<std::array<int, 3>, int> index_;
  std::map<std::pair<int, int>, int> cuts_;
  std::vector<double> value_;  // distance to the surface of each lattice node, m
  std::vector<std::array<int, 4>> cells_;
  FleshMesh mesh_;
};

}  // namespace

double volume(const FleshMesh& mesh, const std::array<int, 4>& t) {
  const Vector3d& o = mesh.nodes[t[0]];
  return (mesh.nodes[t[1]] - o).cross(mesh.nodes[t[2]] - o).dot(mesh.nodes[t[3]] - o) / 6.0;
}

FleshMesh fillCapsules(const std::vector<Capsule>& capsules, double cell) {
  if (!(cell > 0.0))
    throw std::invalid_argument("flesh: cell of " + std::to_string(cell) + " m, expected > 0");
  FleshMesh mesh = Stuffing(capsules, cell).fill();
  if (mesh.tetrahedra.empty())
    throw std::invalid_argument("flesh: nothing inside at a cell of " + std::to_string(cell) + " m");
  return mesh;
}

}  // namespace tactile_clay::hand
