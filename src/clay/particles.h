#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tactile_clay::clay {

/// A vector field over the particles, structure of arrays.
struct VectorField {
  std::vector<float> x, y, z;

  void resize(std::size_t n) { x.resize(n), y.resize(n), z.resize(n); }
  std::size_t size() const { return x.size(); }
  Eigen::Vector3f at(std::size_t i) const { return {x[i], y[i], z[i]}; }
  void set(std::size_t i, const Eigen::Vector3f& v) { x[i] = v.x(), y[i] = v.y(), z[i] = v.z(); }
  void add(std::size_t i, const Eigen::Vector3f& v) { x[i] += v.x(), y[i] += v.y(), z[i] += v.z(); }
};

/// State of the clay. Particle indices never change, so that a particle can be followed through a recording.
struct Particles {
  VectorField position;              // m
  VectorField velocity;              // m/s
  std::vector<float> inverse_mass;   // 1/kg
  std::vector<float> density_ratio;  // rho / rho0
  std::vector<std::uint8_t> material;
  std::vector<std::uint16_t> body;  // of the scene's bodies

  std::size_t size() const { return position.size(); }
};

}  // namespace tactile_clay::clay
