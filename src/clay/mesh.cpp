#include "clay/mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "clay/mesh_topology.h"

namespace tactile_clay::clay {
namespace {

constexpr std::uint32_t faces_a_leaf = 4;
constexpr int deepest = 64;  // depth of a tree at most; each level halves the faces

/// The nearest place of a face, and the normal there. The normal gives the side; it need not have unit
/// length.
struct Nearest {
  double square;  // m^2
  Eigen::Vector3d place;
  const Eigen::Vector3d* normal;
  const Mesh::Face* face;  // the face, if the place is within it; null at an edge or a corner
};

/// The nearest place of a triangle, by the region that contains the point (Ericson 2004, Real-Time Collision
/// Detection, 5.1.5).
Nearest nearestOf(const Mesh::Face& f, const Eigen::Vector3d& p) {
  const Eigen::Vector3d &a = f.corner[0], &b = f.corner[1], &c = f.corner[2];
  const auto at = [&](const Eigen::Vector3d& place, const Eigen::Vector3d& normal,
                      const Mesh::Face* face = nullptr) {
    return Nearest{(p - place).squaredNorm(), place, &normal, face};
  };
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return at(a, f.vertex[0]);
  const Eigen::Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return at(b, f.vertex[1]);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return at(a + d1 / (d1 - d3) * ab, f.edge[0]);
  const Eigen::Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return at(c, f.vertex[2]);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return at(a + d2 / (d2 - d6) * ac, f.edge[2]);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return at(b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), f.edge[1]);
  return at(p - f.normal.dot(ap) * f.normal, f.normal, &f);
}

/// Sets `nearest` to the nearest place of a body, if that is nearer than `nearest` is.
void findNearest(const Mesh::Body& body, const Eigen::Vector3d& p, Nearest& nearest) {
  struct Rest {
    std::uint32_t node;
    double square;
  };
  Rest rest[deepest];
  int size = 0;
  rest[size++] = {0, body.nodes[0].box.squaredExteriorDistance(p)};
  while (size > 0) {
    const Rest next = rest[--size];
    if (next.square >= nearest.square) continue;
    const Mesh::Node& node = body.nodes[next.node];
    if (node.faces == 0) {
      const Rest left{node.first, body.nodes[node.first].box.squaredExteriorDistance(p)};
      const Rest right{node.first + 1, body.nodes[node.first + 1].box.squaredExteriorDistance(p)};
      const bool left_first = left.square <= right.square;
      rest[size++] = left_first ? right : left;  // the farther one is looked at later
      rest[size++] = left_first ? left : right;
      continue;
    }
    for (std::uint32_t f = node.first; f < node.first + node.faces; ++f) {
      const Nearest found = nearestOf(body.faces[f], p);
      if (found.square < nearest.square) nearest = found;
    }
  }
}

SurfacePoint signedBy(const Nearest& nearest, const Eigen::Vector3d& p) {
  if (nearest.normal == nullptr)
    return {INFINITY, Eigen::Vector3d::UnitZ()};  // for a point that is not finite
  if (nearest.face != nullptr)
    return {nearest.face->normal.dot(p - nearest.face->corner[0]), nearest.face->normal};
  const Eigen::Vector3d away = p - nearest.place;
  const double distance = std::sqrt(nearest.square);
  const double side = nearest.normal->dot(away) < 0.0 ? -1.0 : 1.0;
  // On the surface itself rounding would decide the direction.
  constexpr double on_it = 1e-9;  // m
  if (distance < on_it) return {side * distance, nearest.normal->normalized()};
  return {side * distance, side / distance * away};
}

/// Normals of triangles; zero if a triangle is too narrow to have one.
std::vector<Eigen::Vector3d> normalsOf(const ClosedSurface& surface, double narrow) {
  std::vector<Eigen::Vector3d> normals;
  for (const Mesh::Triangle& t : surface.triangles) {
    const Eigen::Vector3d &a = surface.vertices[t[0]], &b = surface.vertices[t[1]],
                          &c = surface.vertices[t[2]];
    const Eigen::Vector3d twice = (b - a).cross(c - a);
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const bool wide = twice.norm() > narrow * longest;
    normals.push_back(wide ? Eigen::Vector3d(twice.normalized()) : Eigen::Vector3d::Zero());
  }
  return normals;
}

double angleAt(const ClosedSurface& surface, const Mesh::Triangle& t, int k) {
  const Eigen::Vector3d u = surface.vertices[t[(k + 1) % 3]] - surface.vertices[t[k]];
  const Eigen::Vector3d v = surface.vertices[t[(k + 2) % 3]] - surface.vertices[t[k]];
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

/// Makes faces with the normals of their edges and corners. A triangle that is only a line is replaced by the
/// triangles beyond it: in the normal of an edge by those beyond its two other edges, in the normal of a
/// corner by the one beyond the opposite edge.
class Normals {
 public:
  Normals(const ClosedSurface& surface, double narrow)
      : of_triangle_(normalsOf(surface, narrow)),
        of_vertex_(surface.vertices.size(), Eigen::Vector3d::Zero()) {
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k)
        of_vertex_[surface.triangles[t][k]] +=
            angleAt(surface, surface.triangles[t], k) *
            (isLine(t) ? of_triangle_[surface.across[t][(k + 1) % 3]] : of_triangle_[t]);
  }
  bool isLine(std::size_t t) const { return of_triangle_[t].isZero(0.0); }
  Mesh::Face face(const ClosedSurface& surface, std::size_t t) const {
    Mesh::Face face;
    face.normal = of_triangle_[t];
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = surface.triangles[t][k], next = surface.across[t][k];
      face.corner[k] = surface.vertices[v];
      face.vertex[k] = of_vertex_[v];
      face.edge[k] = of_triangle_[t] + (isLine(next) ? beyond(surface, next, static_cast<std::uint32_t>(t))
                                                     : of_triangle_[next]);
    }
    return face;
  }

 private:
  Eigen::Vector3d beyond(const ClosedSurface& surface, std::uint32_t line, std::uint32_t from) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      if (surface.across[line][k] != from) sum += of_triangle_[surface.across[line][k]];
    return sum.stableNormalized();
  }

  std::vector<Eigen::Vector3d> of_triangle_, of_vertex_;
};

Eigen::AlignedBox3d boxOfFace(const Mesh::Face& face) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& corner : face.corner) box.extend(corner);
  return box;
}

/// Divides the faces of a node into halves along its longest side, until a node has few faces.
void split(Mesh::Body& body, const std::vector<Mesh::Face>& faces, std::vector<std::uint32_t>& order,
           std::uint32_t node, std::uint32_t first, std::uint32_t last) {
  Eigen::AlignedBox3d box, centres;
  for (std::uint32_t k = first; k < last; ++k) {
    const Eigen::AlignedBox3d of_face = boxOfFace(faces[order[k]]);
    box.extend(of_face);
    centres.extend(of_face.center());
  }
  body.nodes[node].box = box;
  if (last - first <= faces_a_leaf) {
    body.nodes[node].first = first;
    body.nodes[node].faces = last - first;
    return;
  }
  int axis = 0;
  centres.sizes().maxCoeff(&axis);
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(order.begin() + first, order.begin() + middle, order.begin() + last,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double x = boxOfFace(faces[a]).center()[axis],
                                  y = boxOfFace(faces[b]).center()[axis];
                     return x < y || (x == y && a < b);
                   });
  const auto left = static_cast<std::uint32_t>(body.nodes.size());
  body.nodes[node].first = left;
  body.nodes.resize(left + 2);
  split(body, faces, order, left, first, middle);
  split(body, faces, order, left + 1, middle, last);
}

Mesh::Body bodyOf(const std::vector<Mesh::Face>& faces) {
  Mesh::Body body;
  std::vector<std::uint32_t> order(faces.size());
  std::iota(order.begin(), order.end(), 0u);
  body.nodes.resize(1);
  split(body, faces, order, 0, 0, static_cast<std::uint32_t>(faces.size()));
  for (const std::uint32_t f : order) body.faces.push_back(faces[f]);
  return body;
}

}  // namespace

Mesh::Mesh(const std::vector<Eigen::Vector3d>& vertices, const std::vector<Triangle>& triangles) {
  const ClosedSurface surface = closedSurface(vertices, triangles);
  for (const Triangle& t : surface.triangles)
    for (int k = 0; k < 3; ++k) bounds_.extend(surface.vertices[t[k]]);
  volume_ = volumeOf(surface);
  const Normals normals(surface, same_place * bounds_.diagonal().norm());
  std::vector<std::vector<Face>> faces(surface.bodies);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    if (!normals.isLine(t)) {
      faces[surface.body[t]].push_back(normals.face(surface, t));
      ++triangles_;
    }
  for (const std::vector<Face>& of_body : faces)
    if (!of_body.empty()) bodies_.push_back(bodyOf(of_body));
  fillGrid();
}

void Mesh::fillGrid() {
  // Cells along the longest edge: together at most 8 000 cells, filled in a few seconds at most.
  constexpr double cells_along = 20.0;
  cell_ = bounds_.sizes().maxCoeff() / cells_along;
  cells_ = (bounds_.sizes().array() / cell_).ceil().cast<int>().max(1);
  distance_.resize(static_cast<std::size_t>(cells_.prod()));
  for (int z = 0; z < cells_.z(); ++z)
    for (int y = 0; y < cells_.y(); ++y)
      for (int x = 0; x < cells_.x(); ++x) {
        Eigen::Vector3d centre;
        const Eigen::Vector3d within = bounds_.min() + cell_ * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5);
        const std::size_t cell = cellOf(within, centre);
        distance_[cell] = surface(centre).distance;
      }
}

std::size_t Mesh::cellOf(const Eigen::Vector3d& point, Eigen::Vector3d& centre) const {
  const Eigen::Array3i at =
      ((point - bounds_.min()).array() / cell_).floor().max(0.0).min(cells_.cast<double>() - 1.0).cast<int>();
  centre = bounds_.min() + cell_ * (at.cast<double>() + 0.5).matrix();
  return static_cast<std::size_t>((at.z() * cells_.y() + at.y()) * cells_.x() + at.x());
}

double Mesh::atLeast(const Eigen::Vector3d& point) const {
  if (!bounds_.contains(point)) return bounds_.exteriorDistance(point);
  Eigen::Vector3d centre;
  const std::size_t cell = cellOf(point, centre);
  return distance_[cell] - (point - centre).norm();
}

SurfacePoint Mesh::surface(const Eigen::Vector3d& point) const {
  SurfacePoint minimum{INFINITY, Eigen::Vector3d::UnitZ()};
  for (const Body& body : bodies_) {
    // A body whose box is farther away than the surface found so far is not nearer, and does not contain the
    // point.
    const double farthest = minimum.distance > 0.0 ? minimum.distance * minimum.distance : 0.0;
    if (body.nodes[0].box.squaredExteriorDistance(point) > farthest) continue;
    Nearest nearest{INFINITY, point, nullptr, nullptr};
    findNearest(body, point, nearest);
    const SurfacePoint found = signedBy(nearest, point);
    if (found.distance < minimum.distance) minimum = found;
  }
  return minimum;
}

}  // namespace tactile_clay::clay
