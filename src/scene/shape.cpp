#include "scene/shape.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

double boundingVolume(const Shape& shape) {
  if (shape.kind == Shape::Kind::box) return shape.size.prod();
  const double diameter = 2.0 * std::max(shape.size.x(), shape.size.y());
  return diameter * diameter * shape.size.z();
}

std::vector<Eigen::Vector3d> latticeIn(const Shape& shape, double spacing) {
  if (shape.kind == Shape::Kind::box) return latticeInBox(shape.size, spacing);
  return latticeInCylinder(shape.size.x(), shape.size.y(), shape.size.z(), spacing);
}

}  // namespace tactile_clay::scene
