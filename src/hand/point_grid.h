#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

namespace tactile_clay::hand {

/// Points in a hashed grid. Visits them in a fixed order.
class PointGrid {
 public:
  /// @param cell m, about the radius that will be searched
  explicit PointGrid(double cell) : cell_(cell) {}

  void insert(int index, const Eigen::Vector3d& position) {
    cells_[key(cellOf(position))].emplace_back(index, position);
  }

  /// Calls visitor(index, distance) for each point closer than `radius`.
  template <typename Visitor>
  void visit(const Eigen::Vector3d& position, double radius, Visitor&& visitor) const {
    const Eigen::Vector3i low = cellOf(position.array() - radius);
    const Eigen::Vector3i high = cellOf(position.array() + radius);
    for (int x = low.x(); x <= high.x(); ++x)
      for (int y = low.y(); y <= high.y(); ++y)
        for (int z = low.z(); z <= high.z(); ++z) {
          const auto found = cells_.find(key({x, y, z}));
          if (found == cells_.end()) continue;
          for (const auto& [index, point] : found->second) {
            const double distance = (point - position).norm();
            if (distance < radius) visitor(index, distance);
          }
        }
  }

 private:
  Eigen::Vector3i cellOf(const Eigen::Vector3d& position) const {
    return (position / cell_).array().floor().cast<int>();
  }
  // 21 bits a coordinate: exact for every cell within a million of the origin.
  static std::uint64_t key(const Eigen::Vector3i& cell) {
    std::uint64_t k = 0;
    for (int axis = 0; axis < 3; ++axis) k = k << 21U | static_cast<std::uint64_t>(cell[axis] + (1 << 20));
    return k;
  }

  double cell_;  // m
  std::unordered_map<std::uint64_t, std::vector<std::pair<int, Eigen::Vector3d>>> cells_;
};

}  // namespace tactile_clay::hand
