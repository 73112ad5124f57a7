#include "clay/projection.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "clay/lanes.h"
#include "clay/lattice.h"
#include "clay/threads.h"

namespace tactile_clay::clay {
namespace {

constexpr std::size_t grain = 128;

// Shares of full corrections; each is near the largest with which a block comes to rest.
constexpr float density_relaxation = 0.25f;
constexpr float viscosity_relaxation = 0.125f;
constexpr float bond_relaxation = 1.3f;  // over the greater number of bonds of the two ends

/// Runs f(first, last) on chunks of [0, n).
template <typename F>
void parallelChunks(std::size_t n, const F& f) {
  parallelFor((n + grain - 1) / grain, 1, [&](std::size_t c) { f(c * grain, std::min(n, (c + 1) * grain)); });
}

/// The rotation with the antisymmetric part of `gradient`, without trigonometry.
Eigen::Matrix3f rotationOf(const Eigen::Matrix3f& gradient) {
  const Eigen::Vector3f sine =
      0.5f * Eigen::Vector3f(gradient(2, 1) - gradient(1, 2), gradient(0, 2) - gradient(2, 0),
                             gradient(1, 0) - gradient(0, 1));
  const float cosine = std::sqrt(std::max(1.0f - sine.squaredNorm(), 0.0f));
  Eigen::Matrix3f rotation = sine * sine.transpose() / (1.0f + cosine);
  rotation.diagonal().array() += cosine;
  rotation(2, 1) += sine[0], rotation(1, 2) -= sine[0];
  rotation(0, 2) += sine[1], rotation(2, 0) -= sine[1];
  rotation(1, 0) += sine[2], rotation(0, 1) -= sine[2];
  return rotation;
}

}  // namespace

Projection::Projection(const Kernel& kernel, float spacing, const std::vector<Material>& materials)
    : kernel_(kernel), volume_(spacing * spacing * spacing), lattice_sum_(latticeSum(kernel, spacing)) {
  for (const Material& m : materials) {
    viscosity_.push_back(static_cast<float>(m.viscosity));
    friction_.push_back(static_cast<float>(m.friction));
    skin_friction_.push_back(static_cast<float>(m.skin_friction));
    dense_.push_back(m.bulk_modulus > 0.0);
    any_dense_ = any_dense_ || m.bulk_modulus > 0.0;
    viscous_ = viscous_ || m.viscosity > 0.0;
  }
}

void Projection::solve(const Neighbourhood& near, const Particles& particles, const Bonds* bonds,
                       const VectorField& free, int iterations, float dt, Contacts& contacts,
                       VectorField& u) {
  near_ = &near, particles_ = &particles;
  begin(bonds, dt);
  beginContacts(contacts, dt);
  u = free;
  for (int k = 0; k < iterations; ++k) {
    if (any_dense_) projectDensity(u);
    if (viscous_) projectViscosity(u);
    projectBondsAndContacts(u, contacts.contacts());
  }
  slideAnchors(contacts.contacts(), u);
}

void Projection::begin(const Bonds* bonds, float dt) {
  const std::size_t n = particles_->size();
  ratio_.resize(n), moved_.resize(n);
  if (any_dense_) density_gradient_.resize(near_->pairs()), density_step_.resize(n);
  if (viscous_) {
    gradient_.resize(near_->pairs()), own_gradient_.resize(n);
    inverse_.resize(n), weight_.resize(n), compliance_.resize(n);
    multiplier_.resize(n), strain_step_.resize(n);
  }
  parallelChunks(n, [&](std::size_t first, std::size_t last) {
    beginKernels(first, last);
    for (std::size_t i = first; viscous_ && i < last; ++i) beginViscosity(i, dt);
  });
  beginBonds(bonds);
}

void Projection::beginKernels(std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; ++i) {
    Lane total = Lane::Zero(), square, slope;
    Eigen::Vector4f own = Eigen::Vector4f::Zero();
    for (std::uint32_t p = near_->begin(i); p < near_->end(i); p += lane_width) {
      const int count = std::min<int>(lane_width, near_->end(i) - p);
      square.setConstant(4.0f * kernel_.h * kernel_.h);  // beyond the support, where every kernel is zero
      for (int k = 0; k < count; ++k) square[k] = near_->offset()[p + k].squaredNorm();
      const Lane r = square.sqrt();
      total += kernel_.value(r);
      if (!viscous_) continue;
      slope = volume_ * kernel_.slope(r) / r.max(1e-9f);
      for (int k = 0; k < count; ++k) {
        gradient_[p + k] = slope[k] * near_->offset()[p + k];
        own += gradient_[p + k];
      }
    }
    ratio_[i] = (sum(total) + kernel_.sigma) / lattice_sum_;
    if (viscous_) own_gradient_[i] = own;
  }
}

void Projection::beginViscosity(std::size_t i, float dt) {
  const float viscosity = viscosity_[particles_->material[i]];
  compliance_[i] = -1.0f;
  multiplier_[i].setZero();
  for (Eigen::Vector4f& column : strain_step_[i].column) column.setZero();
  if (!(viscosity > 0.0f)) return;
  const std::vector<float>& w = particles_->inverse_mass;
  Eigen::Matrix3f moment = Eigen::Matrix3f::Zero();
  Eigen::Matrix3f weight = w[i] * own_gradient_.at(i) * own_gradient_.at(i).transpose();
  for (std::uint32_t p = near_->begin(i); p < near_->end(i); ++p) {
    const Eigen::Vector3f g = gradient_.at(p);
    moment -= near_->offset().at(p) * g.transpose();
    weight += w[near_->other()[p]] * g * g.transpose();
  }
  const float scale = moment.trace() / 3.0f;
  // Where the neighbours do not span space, there is no velocity gradient to damp.
  if (!(moment.determinant() > 0.02f * scale * scale * scale)) return;
  compliance_[i] = 1.0f / (2.0f * viscosity * volume_ * dt);
  inverse_[i] = moment.inverse();
  weight_[i] = inverse_[i] * weight * inverse_[i].transpose();
}

void Projection::beginBonds(const Bonds* bonds) {
  bonded_ = bonds != nullptr && bonds->size() > 0;
  if (!bonded_) return;
  const std::size_t n = particles_->size();
  link_begin_.assign(n + 1, 0);
  for (std::size_t i = 0; i < n; ++i) {
    link_begin_[i + 1] = link_begin_[i] + static_cast<std::uint32_t>(bonds->end(i) - bonds->begin(i));
  }
  link_.resize(link_begin_[n]), link_offset_.resize(link_begin_[n]);
  const std::vector<float>& w = particles_->inverse_mass;
  const auto count = [&](std::size_t i) { return link_begin_[i + 1] - link_begin_[i]; };
  parallelFor(n, grain, [&](std::size_t i) {
    std::uint32_t l = link_begin_[i];
    for (const Bond* bond = bonds->begin(i); bond != bonds->end(i); ++bond, ++l) {
      const std::uint32_t j = bond->other;
      const float relaxation = bond_relaxation / static_cast<float>(std::max(count(i), count(j)));
      link_[l] = {j, bond->rest_length, std::min(relaxation, 1.0f) * w[i] / (w[i] + w[j])};
      link_offset_[l] = particles_->position[i] - particles_->position[j];
    }
  });
}

void Projection::beginContacts(Contacts& contacts, float dt) {
  force_per_kg_m_ = 1.0f / (dt * dt);
  contact_begin_.assign(particles_->size() + 1, 0);
  for (Contact& c : contacts.contacts()) {
    ++contact_begin_[c.particle + 1];
    c.state = Contact::State::open;
    c.force.setZero(), c.friction.setZero();
  }
  for (std::size_t i = 0; i < particles_->size(); ++i) contact_begin_[i + 1] += contact_begin_[i];
}

void Projection::projectDensity(VectorField& u) {
  parallelChunks(u.size(), [&](std::size_t first, std::size_t last) { measureDensity(u, first, last); });
  parallelChunks(u.size(), [&](std::size_t first, std::size_t last) { moveByDensity(u, first, last); });
}

void Projection::measureDensity(const VectorField& u, std::size_t first, std::size_t last) {
  const std::uint32_t* other = near_->other().data();
  const float* w = particles_->inverse_mass.data();
  const float scale = 1.0f / lattice_sum_;
  for (std::size_t i = first; i < last; ++i) {
    Lane total = Lane::Zero(), square, slope;
    Eigen::Vector4f own = Eigen::Vector4f::Zero(), offset[lane_width];
    float weight = 0.0f;
    const Eigen::Vector4f at = u[i];
    for (std::uint32_t p = near_->begin(i), end = near_->end(i); p < end; p += lane_width) {
      const int count = std::min<int>(lane_width, end - p);
      square.setConstant(4.0f * kernel_.h * kernel_.h);
      for (int k = 0; k < count; ++k) {
        offset[k] = near_->offset()[p + k] + (at - u[other[p + k]]);
        square[k] = offset[k].squaredNorm();
      }
      const Lane r = square.sqrt();
      total += kernel_.value(r);
      slope = scale * kernel_.slope(r) / r.max(1e-9f);
      for (int k = 0; k < count; ++k) {
        const Eigen::Vector4f g = slope[k] * offset[k];
        density_gradient_[p + k] = g;
        own += g;
        weight += w[other[p + k]] * (slope[k] * slope[k] * square[k]);
      }
    }
    const float error = (sum(total) + kernel_.sigma) * scale - 1.0f;
    weight += w[i] * own.squaredNorm();
    const bool pressing = error > 0.0f && weight > 0.0f && dense_[particles_->material[i]];
    density_step_[i] = pressing ? -density_relaxation * error / weight : 0.0f;
  }
}

void Projection::moveByDensity(VectorField& u, std::size_t first, std::size_t last) const {
  const std::uint32_t* other = near_->other().data();
  for (std::size_t i = first; i < last; ++i) {
    Eigen::Vector4f move = Eigen::Vector4f::Zero();
    const float own = density_step_[i];
    for (std::uint32_t p = near_->begin(i), end = near_->end(i); p < end; ++p) {
      move += (own + density_step_[other[p]]) * density_gradient_[p];
    }
    u[i] += particles_->inverse_mass[i] * move;
  }
}

void Projection::projectViscosity(VectorField& u) {
  parallelChunks(u.size(), [&](std::size_t first, std::size_t last) { measureStrain(u, first, last); });
  parallelChunks(u.size(), [&](std::size_t first, std::size_t last) { moveByStrain(u, first, last); });
}

void Projection::measureStrain(const VectorField& u, std::size_t first, std::size_t last) {
  const std::uint32_t* other = near_->other().data();
  for (std::size_t i = first; i < last; ++i) {
    if (compliance_[i] < 0.0f) continue;
    Eigen::Vector4f d0 = Eigen::Vector4f::Zero(), d1 = d0, d2 = d0;
    const Eigen::Vector4f at = u[i];
    for (std::uint32_t p = near_->begin(i), end = near_->end(i); p < end; ++p) {
      const Eigen::Vector4f du = u[other[p]] - at;
      const Eigen::Vector4f& g = gradient_[p];
      d0 += g[0] * du;
      d1 += g[1] * du;
      d2 += g[2] * du;
    }
    Eigen::Matrix3f d;
    d << d0.head<3>(), d1.head<3>(), d2.head<3>();
    const Eigen::Matrix3f gradient = d * inverse_[i];
    const Eigen::Matrix3f rotation = rotationOf(gradient);
    // u^r has the gradient R - I; what is left of u
    const Eigen::Matrix3f left = gradient - rotation;
    Eigen::Matrix3f strain = 0.5f * (left + left.transpose());
    strain.diagonal().array() += 1.0f;
    const float square = strain.squaredNorm();
    // |gradient of the norm of the strain|^2, by Eq. 2
    const float weight =
        square > 0.0f ? (strain * weight_[i]).cwiseProduct(strain).sum() / square : weight_[i].trace() / 3.0f;
    const Eigen::Matrix3f step =
        -viscosity_relaxation / (weight + compliance_[i]) * (strain + compliance_[i] * multiplier_[i]);
    multiplier_[i] += step;
    const Eigen::Matrix3f corrected = step * inverse_[i];
    for (int b = 0; b < 3; ++b) strain_step_[i].column[b] << corrected.col(b), 0.0f;
  }
}

void Projection::moveByStrain(VectorField& u, std::size_t first, std::size_t last) const {
  const std::uint32_t* other = near_->other().data();
  for (std::size_t i = first; i < last; ++i) {
    const Eigen::Vector4f& own = own_gradient_[i];
    const Tensor& s = strain_step_[i];
    Eigen::Vector4f m0 = own[0] * s.column[0], m1 = own[1] * s.column[1], m2 = own[2] * s.column[2];
    for (std::uint32_t p = near_->begin(i), end = near_->end(i); p < end; ++p) {
      const Tensor& step = strain_step_[other[p]];
      const Eigen::Vector4f& g = gradient_[p];
      m0 += g[0] * step.column[0];
      m1 += g[1] * step.column[1];
      m2 += g[2] * step.column[2];
    }
    u[i] -= particles_->inverse_mass[i] * (m0 + m1 + m2);
  }
}

void Projection::projectBondsAndContacts(VectorField& u, std::vector<Contact>& contacts) {
  parallelChunks(u.size(), [&](std::size_t first, std::size_t last) {
    pullBonds(u, first, last);
    for (std::uint32_t c = contact_begin_[first]; c < contact_begin_[last]; ++c) {
      Eigen::Vector3f step = moved_.at(contacts[c].particle);
      projectContact(contacts[c], step);
      moved_.set(contacts[c].particle, step);
    }
  });
  std::swap(u, moved_);
}

void Projection::pullBonds(const VectorField& u, std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; ++i) {
    const Eigen::Vector4f at = u[i];
    Eigen::Vector4f move = Eigen::Vector4f::Zero();
    if (bonded_) {
      for (std::uint32_t l = link_begin_[i], end = link_begin_[i + 1]; l < end; ++l) {
        const Link& link = link_[l];
        const Eigen::Vector4f offset = link_offset_[l] + (at - u[link.other]);
        const float length = std::max(offset.norm(), 1e-9f);
        move -= (link.share * (1.0f - link.rest_length / length)) * offset;
      }
    }
    moved_[i] = at + move;
  }
}

void Projection::projectContact(Contact& c, Eigen::Vector3f& u) const {
  const float depth = c.gap - c.normal.dot(u);
  if (!(depth > 0.0f)) return;
  const std::uint32_t i = c.particle;
  u += depth * c.normal;
  c.state = Contact::State::slide;

  const float mu = (c.solid == Contact::skin ? skin_friction_ : friction_)[particles_->material[i]];
  Eigen::Vector3f pull = c.anchor - (particles_->position.at(i) + u);
  pull -= pull.dot(c.normal) * c.normal;
  const float distance = pull.norm(), limit = mu * depth;
  if (distance > limit) pull *= limit / distance;
  u += pull;

  const float to_force = force_per_kg_m_ / particles_->inverse_mass[i];
  c.friction += to_force * pull;
  c.force += to_force * (depth * c.normal + pull);
}

/// An anchor is left behind by no more than the friction of the step moved the particle.
void Projection::slideAnchors(std::vector<Contact>& contacts, const VectorField& u) const {
  for (Contact& c : contacts) {
    if (c.state == Contact::State::open) continue;
    const Eigen::Vector3f at = particles_->position.at(c.particle) + u.at(c.particle);
    const float moved = c.friction.norm() * particles_->inverse_mass[c.particle] / force_per_kg_m_;
    Eigen::Vector3f behind = c.anchor - at;
    behind -= behind.dot(c.normal) * c.normal;
    const float distance = behind.norm();
    if (distance > moved) behind *= moved / distance;
    c.anchor = at + behind;
  }
}

}  // namespace tactile_clay::clay
