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

/// The pair loops: lanes of x_ij and of the difference of a field over the pair.
struct Pairs {
  Lane x, y, z;

  static Pairs offsets(const Neighbourhood& near, std::uint32_t p) {
    return {Eigen::Map<const Lane>(near.offset().x.data() + p),
            Eigen::Map<const Lane>(near.offset().y.data() + p),
            Eigen::Map<const Lane>(near.offset().z.data() + p)};
  }
  /// u_j - u_i
  static Pairs differences(const Neighbourhood& near, const VectorField& u, std::size_t i, std::uint32_t p) {
    Pairs d;
    const std::uint32_t* other = near.other().data() + p;
    for (int k = 0; k < lane_width; ++k) {
      d.x[k] = u.x[other[k]];
      d.y[k] = u.y[other[k]];
      d.z[k] = u.z[other[k]];
    }
    d.x -= u.x[i];
    d.y -= u.y[i];
    d.z -= u.z[i];
    return d;
  }
};

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
  slope_.resize(near.pairs()), spring_.resize(near.pairs());
  bond_force_.resize(n), ratio_.resize(n), pressing_.resize(n), bulk_.resize(n);
  for (auto& s : stress_) s.resize(n);
  if (viscous_) viscous_stiffness_.resize(n), rotation_.resize(n), correction_.resize(n);
  parallelFor(n, grain, [&](std::size_t i) { beginParticle(particles, bonds, guess, i, dt); });
}

void Potential::beginParticle(const Particles& particles, const Bonds* bonds, const VectorField& guess,
                              std::size_t i, float dt) {
  const Neighbourhood& near = *near_;
  const Material& material = (*materials_)[particles.material[i]];
  Lane total = Lane::Zero();
  Lane moment[6];
  for (Lane& m : moment) m.setZero();
  for (std::uint32_t p = near.begin(i); p < near.end(i); p += lane_width) {
    const Pairs x = Pairs::offsets(near, p);
    const Lane r = (x.x * x.x + x.y * x.y + x.z * x.z).sqrt();
    total += kernel_.value(r);
    const Lane slope = volume_ * kernel_.slope(r) / r.max(1e-9f);
    Eigen::Map<Lane>(slope_.data() + p) = slope;
    Eigen::Map<Lane>(spring_.data() + p).setZero();
    moment[0] -= slope * x.x * x.x;
    moment[1] -= slope * x.x * x.y;
    moment[2] -= slope * x.x * x.z;
    moment[3] -= slope * x.y * x.y;
    moment[4] -= slope * x.y * x.z;
    moment[5] -= slope * x.z * x.z;
  }
  bulk_[i] = static_cast<float>(material.bulk_modulus);
  ratio_[i] = (sum(total) + kernel_.sigma) / lattice_sum_;

  Eigen::Vector3f bond_force = Eigen::Vector3f::Zero();
  if (bonds != nullptr) {
    std::uint32_t p = near.begin(i);
    for (const Bond* bond = bonds->begin(i); bond != bonds->end(i); ++bond) {
      while (near.other()[p] != bond->other) ++p;
      const Eigen::Vector3f x = near.offset().at(p);
      const float length = x.norm();
      const float k = bonds->stiffness(particles.material[i], particles.material[bond->other]);
      spring_[p] = k / (length * length);
      bond_force -= k * (length - bond->rest_length) / length * x;
    }
  }
  bond_force_.set(i, bond_force);

  if (!viscous_) return;
  viscous_stiffness_[i] = 0.0f;
  if (!(material.viscosity > 0.0)) return;
  Eigen::Matrix3f m;
  const float xx = sum(moment[0]), xy = sum(moment[1]), xz = sum(moment[2]);
  const float yy = sum(moment[3]), yz = sum(moment[4]), zz = sum(moment[5]);
  m << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  const float scale = m.trace() / 3.0f;
  // Where the neighbours do not span space, there is no velocity gradient to damp.
  if (!(m.determinant() > 0.02f * scale * scale * scale)) return;
  viscous_stiffness_[i] = static_cast<float>(2.0 * material.viscosity * volume_ / dt);
  correction_[i] = m.inverse();
  rotation_[i] = rotationOf(plainGradient(guess, i) * correction_[i]);
}

Eigen::Matrix3f Potential::plainGradient(const VectorField& u, std::size_t i) const {
  Lane d[9];
  for (Lane& entry : d) entry.setZero();
  for (std::uint32_t p = near_->begin(i); p < near_->end(i); p += lane_width) {
    const Pairs x = Pairs::offsets(*near_, p);
    const Pairs du = Pairs::differences(*near_, u, i, p);
    const Eigen::Map<const Lane> slope(slope_.data() + p);
    const Lane gx = slope * x.x, gy = slope * x.y, gz = slope * x.z;
    d[0] += du.x * gx, d[1] += du.x * gy, d[2] += du.x * gz;
    d[3] += du.y * gx, d[4] += du.y * gy, d[5] += du.y * gz;
    d[6] += du.z * gx, d[7] += du.z * gy, d[8] += du.z * gz;
  }
  Eigen::Matrix3f result;
  result << sum(d[0]), sum(d[1]), sum(d[2]), sum(d[3]), sum(d[4]), sum(d[5]), sum(d[6]), sum(d[7]), sum(d[8]);
  return result;
}

template <bool affine>
void Potential::gatherStress(const VectorField& u, std::size_t i, VectorField& f) {
  Lane d[9], bx = Lane::Zero(), by = Lane::Zero(), bz = Lane::Zero();
  for (Lane& entry : d) entry.setZero();
  for (std::uint32_t p = near_->begin(i); p < near_->end(i); p += lane_width) {
    const Pairs x = Pairs::offsets(*near_, p);
    const Pairs du = Pairs::differences(*near_, u, i, p);
    const Eigen::Map<const Lane> slope(slope_.data() + p), spring(spring_.data() + p);
    const Lane stretch = spring * (x.x * du.x + x.y * du.y + x.z * du.z);
    bx += stretch * x.x, by += stretch * x.y, bz += stretch * x.z;
    const Lane gx = slope * x.x, gy = slope * x.y, gz = slope * x.z;
    d[0] += du.x * gx, d[1] += du.x * gy, d[2] += du.x * gz;
    d[3] += du.y * gx, d[4] += du.y * gy, d[5] += du.y * gz;
    d[6] += du.z * gx, d[7] += du.z * gy, d[8] += du.z * gz;
  }
  Eigen::Matrix3f plain;
  plain << sum(d[0]), sum(d[1]), sum(d[2]), sum(d[3]), sum(d[4]), sum(d[5]), sum(d[6]), sum(d[7]), sum(d[8]);
  Eigen::Vector3f bond_force(sum(bx), sum(by), sum(bz));
  if (affine) bond_force += bond_force_.at(i);
  f.set(i, bond_force);

  Eigen::Matrix3f stress = Eigen::Matrix3f::Zero();
  if (viscous_ && viscous_stiffness_[i] > 0.0f) {
    const Eigen::Matrix3f& r = rotation_[i];
    Eigen::Matrix3f a = r.transpose() * plain * correction_[i];
    if (affine) a += r.transpose() - Eigen::Matrix3f::Identity();
    stress = 0.5f * viscous_stiffness_[i] * (r * (a + a.transpose()) * correction_[i]);
  }
  float compression = -plain.trace() / (volume_ * lattice_sum_);
  if (affine) {
    compression += ratio_[i] - 1.0f;
    pressing_[i] = compression > 0.0f ? bulk_[i] : 0.0f;
  }
  if (pressing_[i] > 0.0f) {
    stress.diagonal().array() -= pressing_[i] * compression / lattice_sum_;
  }
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) stress_[3 * a + b][i] = stress(a, b);
  }
}

void Potential::gatherForce(std::size_t i, VectorField& f) const {
  Lane fx = Lane::Zero(), fy = Lane::Zero(), fz = Lane::Zero();
  for (std::uint32_t p = near_->begin(i); p < near_->end(i); p += lane_width) {
    Lane s[9];
    const std::uint32_t* other = near_->other().data() + p;
    for (int e = 0; e < 9; ++e) {
      const float* stress = stress_[e].data();
      for (int k = 0; k < lane_width; ++k) s[e][k] = stress[other[k]];
      s[e] += stress[i];
    }
    const Pairs x = Pairs::offsets(*near_, p);
    const Eigen::Map<const Lane> slope(slope_.data() + p);
    const Lane gx = slope * x.x, gy = slope * x.y, gz = slope * x.z;
    fx += s[0] * gx + s[1] * gy + s[2] * gz;
    fy += s[3] * gx + s[4] * gy + s[5] * gz;
    fz += s[6] * gx + s[7] * gy + s[8] * gz;
  }
  f.add(i, {sum(fx), sum(fy), sum(fz)});
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
