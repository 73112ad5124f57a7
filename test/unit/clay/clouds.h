#pragma once

#include <random>

#include "clay/neighbourhood.h"
#include "clay/particles.h"

/// Small sets of particles for the tests of single constraints.
namespace tactile_clay::clay {

inline VectorField toField(const std::vector<Eigen::Vector3f>& points) {
  VectorField field;
  field.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) field.set(i, points[i]);
  return field;
}

inline VectorField zeros(std::size_t n) {
  return toField(std::vector<Eigen::Vector3f>(n, Eigen::Vector3f::Zero()));
}

inline Eigen::Vector3f randomVector(std::mt19937& random, float size) {
  std::uniform_real_distribution<float> along(-size, size);
  const float x = along(random), y = along(random), z = along(random);
  return {x, y, z};
}

inline VectorField randomField(std::size_t n, std::mt19937& random, float size) {
  VectorField field;
  field.resize(n);
  for (std::size_t i = 0; i < n; ++i) field.set(i, randomVector(random, size));
  return field;
}

/// A cubic lattice of edge^3 points about the origin, each displaced by up to `jitter` of a spacing.
inline std::vector<Eigen::Vector3f> lattice(int edge, float spacing, float jitter, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::vector<Eigen::Vector3f> points;
  const float middle = 0.5f * static_cast<float>(edge - 1);
  for (int z = 0; z < edge; ++z) {
    for (int y = 0; y < edge; ++y) {
      for (int x = 0; x < edge; ++x) {
        const Eigen::Vector3f at(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
        points.push_back(spacing * (at - Eigen::Vector3f::Constant(middle) + randomVector(random, jitter)));
      }
    }
  }
  return points;
}

/// Particles at rest, of one material.
inline Particles particlesAt(const std::vector<Eigen::Vector3f>& points, float particle_mass) {
  Particles particles;
  particles.position = toField(points);
  particles.velocity = zeros(points.size());
  particles.inverse_mass.assign(points.size(), 1.0f / particle_mass);
  particles.density_ratio.assign(points.size(), 1.0f);
  particles.compression.assign(points.size(), std::numeric_limits<float>::infinity());
  particles.material.assign(points.size(), 0);
  particles.body.assign(points.size(), 0);
  return particles;
}

}  // namespace tactile_clay::clay
