#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace tactile_clay::clay {

/// A vector field over particles or pairs. Each vector fills a slot of 16 bytes, so that the pair loops fetch
/// a neighbour with one load and work on whole vectors. The fourth number of a slot is zero; only Projection
/// uses it.
class VectorField {
 public:
  void resize(std::size_t n) { slots_.resize(n, Eigen::Vector4f::Zero()); }
  std::size_t size() const { return slots_.size(); }

  Eigen::Vector3f at(std::size_t i) const { return slots_[i].head<3>(); }
  void set(std::size_t i, const Eigen::Vector3f& v) { slots_[i].head<3>() = v; }
  void add(std::size_t i, const Eigen::Vector3f& v) { slots_[i].head<3>() += v; }

  const Eigen::Vector4f& operator[](std::size_t i) const { return slots_[i]; }
  /// The slots, four numbers each.
  const float* data() const { return reinterpret_cast<const float*>(slots_.data()); }
  float* data() { return reinterpret_cast<float*>(slots_.data()); }

  Eigen::Vector4f& operator[](std::size_t i) { return slots_[i]; }

 private:
  std::vector<Eigen::Vector4f> slots_;
};

/// Scalar product of two fields over particles [first, last), summed in double precision.
double dot(const VectorField& a, const VectorField& b, std::size_t first, std::size_t last);

}  // namespace tactile_clay::clay
