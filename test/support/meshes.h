#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

namespace tactile_clay {

/// Triangles for tests, anticlockwise as seen from outside.
struct Triangles {
  using Triangle = Eigen::Matrix<std::uint32_t, 3, 1>;

  std::vector<Eigen::Vector3d> vertices;
  std::vector<Triangle> triangles;

  void add(const Triangles& other) {
    const auto first = static_cast<std::uint32_t>(vertices.size());
    vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const Triangle& t : other.triangles) triangles.push_back(t + Triangle::Constant(first));
  }
  void turnRound() {
    for (Triangle& t : triangles) std::swap(t[1], t[2]);
  }
};

inline Triangles boxOfTriangles(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  Triangles box;
  for (int k = 0; k < 8; ++k)
    box.vertices.emplace_back((k & 1 ? high : low).x(), (k & 2 ? high : low).y(), (k & 4 ? high : low).z());
  box.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                   {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return box;
}

/// A globe of `around` times `around / 2` fields.
inline Triangles globeOfTriangles(double radius, int around) {
  Triangles globe;
  const int rings = around / 2;
  const auto at = [around](int ring, int k) {
    return static_cast<std::uint32_t>(1 + (ring - 1) * around + k % around);
  };
  globe.vertices.emplace_back(0.0, 0.0, radius);
  for (int ring = 1; ring < rings; ++ring)
    for (int k = 0; k < around; ++k) {
      const double polar = M_PI * ring / rings, turn = 2.0 * M_PI * k / around;
      globe.vertices.emplace_back(radius * Eigen::Vector3d(std::sin(polar) * std::cos(turn),
                                                           std::sin(polar) * std::sin(turn),
                                                           std::cos(polar)));
    }
  globe.vertices.emplace_back(0.0, 0.0, -radius);
  const auto last = static_cast<std::uint32_t>(globe.vertices.size() - 1);
  for (int k = 0; k < around; ++k) {
    globe.triangles.emplace_back(0, at(1, k), at(1, k + 1));
    for (int ring = 1; ring + 1 < rings; ++ring) {
      globe.triangles.emplace_back(at(ring, k), at(ring + 1, k), at(ring + 1, k + 1));
      globe.triangles.emplace_back(at(ring, k), at(ring + 1, k + 1), at(ring, k + 1));
    }
    globe.triangles.emplace_back(last, at(rings - 1, k + 1), at(rings - 1, k));
  }
  return globe;
}

}  // namespace tactile_clay
