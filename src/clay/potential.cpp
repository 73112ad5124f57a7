#include "clay/potential.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "clay/lanes.h"
#include "clay/lattice.h"
#include "clay/threads.h"

namespace tactile_clay::clay {
namespace {

constexpr std::size_t grain = 128;

/// Rotation of the step: exact where I + gradient is a rotation, second order in its strain otherwise.
Eigen::Matrix3f rotationOf(const Eigen::Matrix3f& gradient) {
  const Eigen::Vector3f axial =
      0.5f * Eigen::Vector3f(gradient(2, 1) - gradient(1, 2), gradient(0, 2) - gradient(2, 0),
                             gradient(1, 0) - gradient(0, 1));
  const float sine = axial.norm();
  if (!(sine > 1e-12f)) return Eigen::Matrix3f::Identity();
  return Eigen::AngleAxisf(std::asin(std::min(sine, 1.0f)), axial / sine).toRotationMatrix();
}

}  // namespace

Potential::Potential(const Kernel& kernel, float spacing, const std::vector<Material>& materials)
    : kernel_(kernel),
      volume_(spacing * spacing * spacing),
      lattice_sum_(latticeSum(kernel, spacing)),
      materials_(&materials) {
  viscous_ =
      std::any_of(materials.begin(), materials.end(), [](const Material& m) { return m.viscosity > 0.0; });
}

void Potential::begin(const Neighbourhood& near, const Particles& particles, const Bonds* bonds,
                      const VectorField& guess, float dt) {
  near_ = &near;
  const std::size_t n = particles.size();
  gradient_.resize(near.pairs());
  for (VectorField* field : {&own_gradient_, &bond_force_}) field->resize(n);
  ratio_.resize(n), pressing_.resize(n), bulk_.resize(n), stress_.resize(n);
  if (viscous_) viscous_stiffness_.resize(n), rotation_.resize(n), correction_.resize(n);
  layOutSprings(bonds, n);
  parallelFor(n, grain, [&](std::size_t i) {
    beginKernels(particles, i);
    if (bonds != nullptr) beginSprings(particles, *bonds, i);
    if (viscous_) beginViscosity(particles, guess, i, dt);
  });
}

void Potential::layOutSprings(const Bonds* bonds, std::size_t n) {
  spring_begin_.assign(n + 1, 0);
  if (bonds == nullptr) return;
  for (std::size_t i = 0; i < n; ++i) {
    spring_begin_[i + 1] = spring_begin_[i] + static_cast<std::uint32_t>(bonds->end(i) - bonds->begin(i));
  }
  spring_.resize(spring_begin_[n]), spring_other_.resize(spring_begin_[n]);
}

void Potential::beginKernels(const Particles& particles, std::size_t i) {
  const Neighbourhood& near = *near_;
  Lane total = Lane::Zero(), square, slope;
  Eigen::Vector4f own = Eigen::Vector4f::Zero();
  for (std::uint32_t p = near.begin(i); p < near.end(i); p += lane_width) {
    const int count = std::min<int>(lane_width, near.end(i) - p);
    square.setConstant(4.0f * kernel_.h * kernel_.h);  // beyond the support, where every kernel is zero
    for (int k = 0; k < count; ++k) square[k] = near.offset()[p + k].squaredNorm();
    const Lane r = square.sqrt();
    total += kernel_.value(r);
    slope = volume_ * kernel_.slope(r) / r.max(1e-9f);
    for (int k = 0; k < count; ++k) {
      gradient_[p + k] = slope[k] * near.offset()[p + k];
      own += gradient_[p + k];
    }
  }
  own_gradient_[i] = own;
  bulk_[i] = static_cast<float>((*materials_)[particles.material[i]].bulk_modulus);
  ratio_[i] = (sum(total) + kernel_.sigma) / lattice_sum_;
}

void Potential::beginSprings(const Particles& particles, const Bonds& bonds, std::size_t i) {
  Eigen::Vector4f force = Eigen::Vector4f::Zero();
  std::uint32_t s = spring_begin_[i];
  std::uint32_t p = near_->begin(i);
  for (const Bond* bond = bonds.begin(i); bond != bonds.end(i); ++bond, ++s) {
    while (near_->other()[p] != bond->other) ++p;  // bonds stand in the order of the neighbours
    const Eigen::Vector4f& x = near_->offset()[p];
    const float length = x.norm();
    const float k = bonds.stiffness(particles.material[i], particles.material[bond->other]);
    spring_other_[s] = bond->other;
    spring_[s] = std::sqrt(k) / length * x;
    force -= k * (length - bond->rest_length) / length * x;
  }
  bond_force_[i] = force;
}

void Potential::beginViscosity(const Particles& particles, const VectorField& guess, std::size_t i,
                               float dt) {
  const Material& material = (*materials_)[particles.material[i]];
  viscous_stiffness_[i] = 0.0f;
  if (!(material.viscosity > 0.0)) return;
  // The gradient that the plain sum gives to u = x; symmetric.
  Eigen::Matrix3f moment = Eigen::Matrix3f::Zero();
  for (std::uint32_t p = near_->begin(i); p < near_->end(i); ++p) {
    moment -= near_->offset().at(p) * gradient_.at(p).transpose();
  }
  const float scale = moment.trace() / 3.0f;
  // Where the neighbours do not span space, there is no velocity gradient to damp.
  if (!(moment.determinant() > 0.02f * scale * scale * scale)) return;
  viscous_stiffness_[i] = static_cast<float>(2.0 * material.viscosity * volume_ / dt);
  correction_[i] = moment.inverse();
  rotation_[i] = rotationOf(plainGradient(guess, i) * correction_[i]);
}

Eigen::Matrix3f Potential::plainGradient(const VectorField& u, std::size_t i) const {
  Eigen::Vector4f d0 = Eigen::Vector4f::Zero(), d1 = d0, d2 = d0;
  const Eigen::Vector4f own = u[i];
  const std::uint32_t* other = near_->other().data();
  for (std::uint32_t p = near_->begin(i), end = near_->end(i); p < end; ++p) {
    const Eigen::Vector4f du = u[other[p]] - own;
    const Eigen::Vector4f& g = gradient_[p];
    d0 += g[0] * du;
    d1 += g[1] * du;
    d2 += g[2] * du;
  }
  Eigen::Matrix3f d;
  d << d0.head<3>(), d1.head<3>(), d2.head<3>();
  return d;
}

template <bool affine>
void Potential::gatherStress(const VectorField& u, std::size_t i, VectorField& f) {
  Eigen::Vector4f bond_force = affine ? bond_force_[i] : Eigen::Vector4f::Zero();
  for (std::uint32_t s = spring_begin_[i], end = spring_begin_[i + 1]; s < end; ++s) {
    bond_force += spring_[s].dot(u[spring_other_[s]] - u[i]) * spring_[s];
  }
  f[i] = bond_force;

  const Eigen::Matrix3f plain = plainGradient(u, i);
  Eigen::Matrix3f stress = Eigen::Matrix3f::Zero();
  if (viscous_ && viscous_stiffness_[i] > 0.0f) {
    const Eigen::Matrix3f& r = rotation_[i];
    const Eigen::Matrix3f corrected = plain * correction_[i];
    Eigen::Matrix3f a = r.transpose() * corrected;
    if (affine) a += r.transpose() - Eigen::Matrix3f::Identity();
    const Eigen::Matrix3f symmetric = 0.5f * viscous_stiffness_[i] * (a + a.transpose());
    const Eigen::Matrix3f turned = r * symmetric;
    stress = turned * correction_[i];
  }
  float compression = -plain.trace() / (volume_ * lattice_sum_);
  if (affine) {
    compression += ratio_[i] - 1.0f;
    pressing_[i] = compression > 0.0f ? bulk_[i] : 0.0f;
  }
  if (pressing_[i] > 0.0f) stress.diagonal().array() -= pressing_[i] * compression / lattice_sum_;
  for (int b = 0; b < 3; ++b) stress_[i].column[b] << stress.col(b), 0.0f;
}

void Potential::gatherForce(std::size_t i, VectorField& f) const {
  // sum_j (S_i + S_j) p_ij, of which sum_j p_ij is known
  const Eigen::Vector4f& own = own_gradient_[i];
  const Stress& s = stress_[i];
  Eigen::Vector4f f0 = own[0] * s.column[0], f1 = own[1] * s.column[1], f2 = own[2] * s.column[2];
  const std::uint32_t* other = near_->other().data();
  for (std::uint32_t p = near_->begin(i), end = near_->end(i); p < end; ++p) {
    const Stress& stress = stress_[other[p]];
    const Eigen::Vector4f& g = gradient_[p];
    f0 += g[0] * stress.column[0];
    f1 += g[1] * stress.column[1];
    f2 += g[2] * stress.column[2];
  }
  f[i] += f0 + f1 + f2;
}

template <bool affine>
void Potential::evaluate(const VectorField& u, VectorField& f) {
  const std::size_t n = ratio_.size();
  parallelFor(n, grain, [&](std::size_t i) { gatherStress<affine>(u, i, f); });
  parallelFor(n, grain, [&](std::size_t i) { gatherForce(i, f); });
}

template void Potential::evaluate<true>(const VectorField&, VectorField&);
template void Potential::evaluate<false>(const VectorField&, VectorField&);

}  // namespace tactile_clay::clay
