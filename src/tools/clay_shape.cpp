#include "tools/clay_shape.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "clay/kernel.h"
#include "clay/lattice.h"

namespace tactile_clay::tools {

namespace {

/// Key of a cell within 2^20 cells of the origin: 21 bits for each coordinate.
std::uint64_t keyOf(const Eigen::Vector3i& cell) {
  std::uint64_t key = 0;
  for (int k = 0; k < 3; ++k)
    key = key << 21U | static_cast<std::uint64_t>((cell[k] + (1 << 20)) & ((1 << 21) - 1));
  return key;
}

}  // namespace

double volumeOf(const clay::VectorField& position, double spacing) {
  const clay::Kernel kernel(static_cast<float>(2.0 * spacing));
  const float full = clay::latticeSum(kernel, static_cast<float>(spacing));
  const float edge = static_cast<float>(0.5 * spacing);  // m, of a cell
  const int reach = 4;                                   // cells within the support radius
  std::unordered_map<std::uint64_t, float> cells;        // the sum at the centre of each, 1/m^3
  for (std::size_t i = 0; i < position.size(); ++i) {
    const Eigen::Vector3f at = position.at(i);
    const Eigen::Vector3i middle = (at / edge).array().floor().cast<int>();
    for (int a = -reach; a <= reach; ++a) {
      for (int b = -reach; b <= reach; ++b) {
        for (int c = -reach; c <= reach; ++c) {
          const Eigen::Vector3i cell = middle + Eigen::Vector3i(a, b, c);
          const Eigen::Vector3f centre = edge * (cell.cast<float>().array() + 0.5f).matrix();
          const float value = kernel.value((centre - at).norm());
          if (value > 0.0f) cells[keyOf(cell)] += value;
        }
      }
    }
  }
  const auto inside =
      std::count_if(cells.begin(), cells.end(), [&](const auto& cell) { return cell.second >= 0.5f * full; });
  return static_cast<double>(inside) * edge * edge * edge;
}

double heightOf(const clay::VectorField& position, const std::vector<clay::Solid>& solids,
                const Eigen::Vector3d& gravity, double spacing) {
  double highest = 0.0;
  for (std::size_t i = 0; i < position.size(); ++i) {
    double nearest = INFINITY;
    for (const clay::Solid& solid : solids) {
      const clay::SurfacePoint point = surface(solid, solid.pose.inverse() * position.at(i).cast<double>());
      if ((solid.pose.linear() * point.normal).dot(gravity) < 0.0)
        nearest = std::min(nearest, point.distance);
    }
    if (std::isfinite(nearest)) highest = std::max(highest, nearest + 0.5 * spacing);
  }
  return highest;
}

}  // namespace tactile_clay::tools
