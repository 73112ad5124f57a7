#include "scene/shape.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace tactile_clay::scene {
namespace {

int layers(double length, double spacing) {
  return static_cast<int>(std::lround(length / spacing));
}

std::vector<Eigen::Vector3d> latticeInBox(const Eigen::Vector3d& size, double spacing) {
  std::vector<Eigen::Vector3d> points;
  const int nx = layers(size.x(), spacing), ny = layers(size.y(), spacing), nz = layers(size.z(), spacing);
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        points.push_back(spacing * Eigen::Vector3d(x - 0.5 * (nx - 1), y - 0.5 * (ny - 1), z + 0.5));
      }
    }
  }
  return points;
}

std::vector<Eigen::Vector3d> latticeInCylinder(double below, double above, double height, double spacing) {
  std::vector<Eigen::Vector3d> points;
  const int nz = layers(height, spacing);
  for (int z = 0; z < nz; ++z) {
    const double share = (z + 0.5) / nz;
    const double radius = ((1.0 - share) * below + share * above) / spacing;
    const int reach = static_cast<int>(std::ceil(radius));
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        if (x * x + y * y <= radius * radius) points.push_back(spacing * Eigen::Vector3d(x, y, z + 0.5));
      }
    }
  }
  return points;
}

using Distance = std::function<double(const Eigen::Vector3d&)>;  // m, negative inside

struct Point {
  Eigen::Vector3d place;
  double distance;
};

/// Points of a lattice about the middle of a box that are inside a shape, or not farther out than `around`,
/// m. Along a row, points are skipped that the last distance tells enough about: a distance changes by no
/// more than the way between two points. Points deeper than `around` may have a smaller depth than theirs,
/// but not less than `around`.
/// @param phase of each axis: 0 if the middle is a point, 1 if it lies between two points
std::vector<Point> latticeNear(const Eigen::AlignedBox3d& box, const Distance& distance, double spacing,
                               const Eigen::Array3i& phase, double around) {
  const Eigen::Array3d first = 0.5 * phase.cast<double>();
  const Eigen::Array3i reach = (0.5 * box.sizes().array() / spacing).ceil().cast<int>();
  std::vector<Point> points;
  const auto addRow = [&](int x, int end, const auto& at) {
    while (x <= end) {
      const double d = box.exteriorDistance(at(x)) > around ? around : distance(at(x));
      const int next = x + 1 + static_cast<int>(std::max(0.0, (std::abs(d) - around) / spacing));
      if (d < around) points.push_back({at(x), d});
      for (int i = x + 1; d < 0.0 && i < next; ++i) points.push_back({at(i), d + spacing * (i - x)});
      x = next;
    }
  };
  for (int z = -reach.z() - 1; z <= reach.z(); ++z)
    for (int y = -reach.y() - 1; y <= reach.y(); ++y)
      addRow(-reach.x() - 1, reach.x(), [&](int x) -> Eigen::Vector3d {
        return box.center() + spacing * (Eigen::Array3d(x, y, z) + first).matrix();
      });
  return points;
}

/// Distance from the shape, m, up to which points count, so that their number is as close as possible to the
/// wanted number. Points at equal distances stay together, which keeps the symmetry.
/// @return negative: inside the shape
double bestSurface(const std::vector<Point>& points, double wanted, double around) {
  std::vector<double> distances;
  for (const Point& p : points)
    if (p.distance > -around) distances.push_back(p.distance);
  const std::size_t deep = points.size() - distances.size();
  std::sort(distances.begin(), distances.end());
  const double rounding = 1e-6 * around;
  double best = -around, minimum = std::abs(static_cast<double>(deep) - wanted);
  for (std::size_t k = 0; k < distances.size(); ++k) {
    if (k + 1 < distances.size() && distances[k + 1] - distances[k] < rounding) continue;
    const double surface = distances[k] + rounding,
                 off = std::abs(static_cast<double>(deep + k + 1) - wanted);
    if (off < minimum || (off == minimum && std::abs(surface) < std::abs(best))) {
      minimum = off;
      best = surface;
    }
  }
  return best;
}

std::vector<Eigen::Vector3d> latticeOfVolume(const Eigen::AlignedBox3d& box, double volume,
                                             const Distance& distance, double spacing) {
  constexpr double max_moved = 0.15;      // spacings, by which the surface may be larger or smaller
  constexpr double enough_for_one = 2e5;  // particles; the volume of so many is right in any lattice
  const double wanted = volume / (spacing * spacing * spacing), around = max_moved * spacing;
  std::vector<Point> best;
  double minimum = INFINITY;
  for (int k = 0; k < (wanted > enough_for_one ? 1 : 8); ++k) {
    // The middle between points is tried first: then a shape of whole layers gets all its layers, like a box.
    const Eigen::Array3i phase(1 - k % 2, 1 - k / 2 % 2, 1 - k / 4);
    std::vector<Point> points = latticeNear(box, distance, spacing, phase, around);
    const double surface = bestSurface(points, wanted, around);
    points.erase(
        std::remove_if(points.begin(), points.end(), [&](const Point& p) { return p.distance > surface; }),
        points.end());
    const double off = std::abs(static_cast<double>(points.size()) - wanted);
    if (off < minimum) {
      minimum = off;
      best = std::move(points);
    }
  }
  std::vector<Eigen::Vector3d> places;
  for (const Point& p : best) places.push_back(p.place);
  return places;
}

Eigen::AlignedBox3d boxOf(const Shape& shape) {
  if (shape.kind == Shape::Kind::mesh) return shape.mesh->bounds();
  const double r = shape.size.x();
  return {Eigen::Vector3d(-r, -r, 0.0), Eigen::Vector3d(r, r, 2.0 * r)};
}

}  // namespace

Eigen::Vector3d extentsOf(const Shape& shape) {
  if (shape.kind == Shape::Kind::box) return shape.size;
  if (shape.kind != Shape::Kind::cylinder) return boxOf(shape).sizes();
  const double diameter = 2.0 * std::max(shape.size.x(), shape.size.y());
  return {diameter, diameter, shape.size.z()};
}

double cellsAround(const Shape& shape, double spacing) {
  return (extentsOf(shape) / spacing).cwiseMax(1.0).prod();
}

std::vector<Eigen::Vector3d> latticeIn(const Shape& shape, double spacing) {
  const double radius = shape.size.x();
  switch (shape.kind) {
    case Shape::Kind::box:
      return latticeInBox(shape.size, spacing);
    case Shape::Kind::cylinder:
      return latticeInCylinder(shape.size.x(), shape.size.y(), shape.size.z(), spacing);
    case Shape::Kind::sphere:
      return latticeOfVolume(
          boxOf(shape), 4.0 / 3.0 * M_PI * radius * radius * radius,
          [&](const Eigen::Vector3d& p) { return (p - Eigen::Vector3d(0.0, 0.0, radius)).norm() - radius; },
          spacing);
    case Shape::Kind::mesh:
      break;
  }
  return latticeOfVolume(
      boxOf(shape), shape.mesh->volume(),
      [&](const Eigen::Vector3d& p) { return shape.mesh->surface(p).distance; }, spacing);
}

}  // namespace tactile_clay::scene
