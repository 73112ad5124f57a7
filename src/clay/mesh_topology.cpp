#include "clay/mesh_topology.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <unordered_map>

namespace tactile_clay::clay {
namespace {

using Triangle = Mesh::Triangle;

struct Cell {
  std::int64_t x, y, z;
  bool operator==(const Cell& other) const { return x == other.x && y == other.y && z == other.z; }
};
struct HashOfCell {
  std::size_t operator()(const Cell& c) const {
    return static_cast<std::size_t>(c.x * 73856093) ^ static_cast<std::size_t>(c.y * 19349663) ^
           static_cast<std::size_t>(c.z * 83492791);
  }
};

/// The vertices, without those at the place of an earlier vertex.
/// @param number gets, for each vertex, its index in the result
std::vector<Eigen::Vector3d> joined(const std::vector<Eigen::Vector3d>& vertices, double tolerance,
                                    std::vector<std::uint32_t>& number) {
  std::vector<Eigen::Vector3d> places;
  std::unordered_multimap<Cell, std::uint32_t, HashOfCell> cells;
  const double cell = 2.0 * tolerance;
  const auto index = [cell](double x) { return static_cast<std::int64_t>(std::floor(x / cell)); };
  for (const Eigen::Vector3d& v : vertices) {
    // A place within the tolerance lies in the cell of the vertex, or beyond the side to which the vertex is
    // nearer.
    std::int64_t low[3], high[3];
    for (int k = 0; k < 3; ++k) {
      low[k] = index(v[k] - tolerance);
      high[k] = index(v[k] + tolerance);
    }
    auto same = static_cast<std::uint32_t>(places.size());
    for (std::int64_t x = low[0]; x <= high[0]; ++x)
      for (std::int64_t y = low[1]; y <= high[1]; ++y)
        for (std::int64_t z = low[2]; z <= high[2]; ++z) {
          const auto range = cells.equal_range({x, y, z});
          for (auto at = range.first; at != range.second; ++at)
            if ((places[at->second] - v).norm() <= tolerance) same = std::min(same, at->second);
        }
    if (same == places.size()) {
      places.push_back(v);
      cells.emplace(Cell{index(v.x()), index(v.y()), index(v.z())}, same);
    }
    number.push_back(same);
  }
  return places;
}

struct Side {  // a triangle at an edge
  std::uint32_t low, high, triangle, corner;
};

/// Fills `across`.
/// @throws std::invalid_argument if an edge does not have exactly two triangles
void matchEdges(ClosedSurface& surface) {
  std::vector<Side> sides;
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t a = surface.triangles[t][k], b = surface.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), t, k});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  surface.across.resize(surface.triangles.size());
  std::size_t open = 0, shared = 0;
  for (std::size_t first = 0, last; first < sides.size(); first = last) {
    for (last = first + 1;
         last < sides.size() && sides[last].low == sides[first].low && sides[last].high == sides[first].high;)
      ++last;
    open += last - first == 1 ? 1 : 0;
    shared += last - first > 2 ? 1 : 0;
    if (last - first != 2) continue;
    const Side &a = sides[first], &b = sides[first + 1];
    surface.across[a.triangle][a.corner] = b.triangle;
    surface.across[b.triangle][b.corner] = a.triangle;
  }
  if (open > 0)
    throw std::invalid_argument("is not closed: " + std::to_string(open) + " open edges, expected none");
  if (shared > 0)
    throw std::invalid_argument("has " + std::to_string(shared) +
                                " edges of more than two triangles, expected none");
}

void turnRound(ClosedSurface& surface, std::uint32_t t) {
  // Edges 0, 1, 2 of a, b, c are edges 2, 1, 0 of a, c, b.
  std::swap(surface.triangles[t][1], surface.triangles[t][2]);
  std::swap(surface.across[t][0], surface.across[t][2]);
}

/// Whether a triangle runs along an edge from a to b.
bool runs(const Triangle& triangle, std::uint32_t a, std::uint32_t b) {
  for (int k = 0; k < 3; ++k)
    if (triangle[k] == a && triangle[(k + 1) % 3] == b) return true;
  return false;
}

/// Finds the connected parts of the surface (bodies), and turns all triangles of a body the same way.
void findBodies(ClosedSurface& surface) {
  constexpr auto none = static_cast<std::uint32_t>(-1);
  surface.body.assign(surface.triangles.size(), none);
  std::vector<std::uint32_t> rest;
  for (std::uint32_t seed = 0; seed < surface.triangles.size(); ++seed) {
    if (surface.body[seed] != none) continue;
    const std::uint32_t body = surface.bodies++;
    surface.body[seed] = body;
    rest.push_back(seed);
    while (!rest.empty()) {
      const std::uint32_t t = rest.back();
      rest.pop_back();
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t a = surface.triangles[t][k], b = surface.triangles[t][(k + 1) % 3];
        const std::uint32_t next = surface.across[t][k];
        const bool against = runs(surface.triangles[next], a, b);
        if (surface.body[next] == none) {
          if (against) turnRound(surface, next);
          surface.body[next] = body;
          rest.push_back(next);
        } else if (against) {
          throw std::invalid_argument("has one side only, expected an inside and an outside");
        }
      }
    }
  }
}

std::vector<double> volumesOf(const ClosedSurface& surface) {
  std::vector<double> volumes(surface.bodies, 0.0);
  const Eigen::Vector3d about = surface.vertices.empty() ? Eigen::Vector3d::Zero() : surface.vertices[0];
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto corner = [&](int k) -> Eigen::Vector3d {
      return surface.vertices[surface.triangles[t][k]] - about;
    };
    volumes[surface.body[t]] += corner(0).dot(corner(1).cross(corner(2))) / 6.0;
  }
  return volumes;
}

void turnRound(ClosedSurface& surface, const std::vector<bool>& bodies) {
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t)
    if (bodies[surface.body[t]]) turnRound(surface, t);
}

/// Whether a body encloses a point, by the sum of the solid angles of its triangles (Van Oosterom & Strackee
/// 1983).
bool encloses(const ClosedSurface& surface, std::uint32_t body, const Eigen::Vector3d& point) {
  double angle = 0.0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    if (surface.body[t] != body) continue;
    const Triangle& corners = surface.triangles[t];
    const Eigen::Vector3d a = surface.vertices[corners[0]] - point, b = surface.vertices[corners[1]] - point,
                          c = surface.vertices[corners[2]] - point;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle +=
        2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return std::abs(angle) > 2.0 * M_PI;
}

/// Turns bodies outwards. A body that is turned inwards and inside another one is a hole of that one, and
/// joins it.
void turnOutwards(ClosedSurface& surface) {
  const std::vector<double> volumes = volumesOf(surface);
  std::vector<Eigen::AlignedBox3d> boxes(surface.bodies);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) boxes[surface.body[t]].extend(surface.vertices[surface.triangles[t][k]]);
  const auto largest = std::max_element(volumes.begin(), volumes.end(),
                                        [](double a, double b) { return std::abs(a) < std::abs(b); });
  const double out = *largest < 0.0 ? -1.0 : 1.0;
  std::vector<bool> turned(surface.bodies, out < 0.0);
  std::vector<std::uint32_t> joins(surface.bodies), corner(surface.bodies);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    corner[surface.body[t]] = surface.triangles[t][0];
  for (std::uint32_t b = 0; b < surface.bodies; ++b) {
    joins[b] = b;
    if (out * volumes[b] >= 0.0) continue;
    double minimum = INFINITY;
    for (std::uint32_t around = 0; around < surface.bodies; ++around) {
      const double volume = out * volumes[around];
      if (volume > 0.0 && volume < minimum && boxes[around].contains(boxes[b]) &&
          encloses(surface, around, surface.vertices[corner[b]])) {
        minimum = volume;
        joins[b] = around;
      }
    }
    if (joins[b] == b) turned[b] = !turned[b];
  }
  turnRound(surface, turned);
  for (std::uint32_t& body : surface.body) body = joins[body];
}

}  // namespace

double volumeOf(const ClosedSurface& surface) {
  double volume = 0.0;
  for (const double v : volumesOf(surface)) volume += v;
  return volume;
}

ClosedSurface closedSurface(const std::vector<Eigen::Vector3d>& vertices,
                            const std::vector<Triangle>& triangles) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& v : vertices) {
    if (!v.allFinite()) throw std::invalid_argument("has a corner that is not finite, expected numbers in m");
    box.extend(v);
  }
  const double diagonal = vertices.empty() ? 0.0 : box.diagonal().norm();
  if (!(diagonal > 0.0)) throw std::invalid_argument("has no size, expected triangles");
  ClosedSurface surface;
  std::vector<std::uint32_t> number;
  surface.vertices = joined(vertices, same_place * diagonal, number);
  for (const Triangle& t : triangles) {
    const Triangle corners(number.at(t[0]), number.at(t[1]), number.at(t[2]));
    if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0])
      surface.triangles.push_back(corners);
  }
  if (surface.triangles.empty()) throw std::invalid_argument("has no triangles, expected a closed surface");
  matchEdges(surface);
  findBodies(surface);
  turnOutwards(surface);
  constexpr double nothing = 1e-12;  // share of the cube of the diagonal
  if (!(volumeOf(surface) > nothing * std::pow(diagonal, 3.0)))
    throw std::invalid_argument("encloses no volume, expected a closed surface about some");
  return surface;
}

}  // namespace tactile_clay::clay
