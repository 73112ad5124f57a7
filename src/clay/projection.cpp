#include "clay/projection.h"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

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

using Tensor = Projection::Tensor;

/// Eight vectors, lane by lane.
struct Lanes {
  Lane x, y, z;
  Lane squaredNorm() const { return x * x + y * y + z * z; }
};

#ifdef __SSE2__
inline Lanes transposed(const Eigen::Vector4f* v) {
  Lanes lanes;
  for (int half = 0; half < lane_width; half += 4, v += 4) {
    __m128 a = _mm_load_ps(v[0].data()), b = _mm_load_ps(v[1].data()), c = _mm_load_ps(v[2].data()),
           d = _mm_load_ps(v[3].data());
    _MM_TRANSPOSE4_PS(a, b, c, d);
    _mm_store_ps(lanes.x.data() + half, a);
    _mm_store_ps(lanes.y.data() + half, b);
    _mm_store_ps(lanes.z.data() + half, c);
  }
  return lanes;
}
#else
inline Lanes transposed(const Eigen::Vector4f* v) {
  Lanes lanes;
  for (int k = 0; k < lane_width; ++k) lanes.x[k] = v[k][0], lanes.y[k] = v[k][1], lanes.z[k] = v[k][2];
  return lanes;
}
#endif

/// x_i - x_j of eight pairs.
inline Lanes offsets(const VectorField& x, std::size_t i, const std::uint32_t* other) {
  Eigen::Vector4f v[lane_width];
  for (int k = 0; k < lane_width; ++k) v[k] = x[i] - x[other[k]];
  return transposed(v);
}

/// The same after the displacements u. Differences are formed first: they are small and exact.
inline Lanes offsets(const VectorField& x, const VectorField& u, std::size_t i, const std::uint32_t* other) {
  Eigen::Vector4f v[lane_width];
  for (int k = 0; k < lane_width; ++k) v[k] = (x[i] - x[other[k]]) + (u[i] - u[other[k]]);
  return transposed(v);
}

inline Eigen::Map<Lane, Eigen::Aligned16> asLane(float* values) {
  return Eigen::Map<Lane, Eigen::Aligned16>(values);
}
inline Eigen::Map<const Lane, Eigen::Aligned16> asLane(const float* values) {
  return Eigen::Map<const Lane, Eigen::Aligned16>(values);
}

std::uint32_t wholeLanes(std::uint32_t count) {
  return (count + lane_width - 1) / lane_width * lane_width;
}

Eigen::Matrix3f matrixOf(const Eigen::Vector4f (&columns)[3]) {
  Eigen::Matrix3f matrix;
  matrix << columns[0].head<3>(), columns[1].head<3>(), columns[2].head<3>();
  return matrix;
}

inline Lane taken(const float* values, const std::uint32_t* at) {
  Lane lane;
  for (int k = 0; k < lane_width; ++k) lane[k] = values[at[k]];
  return lane;
}

/// sym(gradient - R) with R the rotation whose antisymmetric part is that of the gradient, I + grad u^r.
/// \param gradient of the displacements u, by columns
Tensor strainOf(const Tensor& gradient) {
  const auto at = [&](int row, int column) { return gradient.column[column][row]; };
  // axis times sine of the angle
  const Eigen::Vector3f turn =
      0.5f * Eigen::Vector3f(at(2, 1) - at(1, 2), at(0, 2) - at(2, 0), at(1, 0) - at(0, 1));
  const float cosine = std::sqrt(std::max(1.0f - turn.squaredNorm(), 0.0f)), bend = 1.0f / (1.0f + cosine);
  const auto strain = [&](int row, int column) {
    return 0.5f * (at(row, column) + at(column, row)) - bend * turn[row] * turn[column];
  };
  const float xy = strain(0, 1), yz = strain(1, 2), zx = strain(2, 0), stretch = 1.0f - cosine;
  Tensor result;
  result.column[0] << strain(0, 0) + stretch, xy, zx, 0.0f;
  result.column[1] << xy, strain(1, 1) + stretch, yz, 0.0f;
  result.column[2] << zx, yz, strain(2, 2) + stretch, 0.0f;
  return result;
}

Eigen::Vector4f product(const Tensor& a, const Eigen::Vector4f& b) {
  return b[0] * a.column[0] + b[1] * a.column[1] + b[2] * a.column[2];
}
Tensor product(const Tensor& a, const Tensor& b) {
  return {{product(a, b.column[0]), product(a, b.column[1]), product(a, b.column[2])}};
}
float dot(const Tensor& a, const Tensor& b) {
  return a.column[0].dot(b.column[0]) + a.column[1].dot(b.column[1]) + a.column[2].dot(b.column[2]);
}

Tensor tensorOf(const Eigen::Matrix3f& matrix) {
  Tensor tensor;
  for (int b = 0; b < 3; ++b) tensor.column[b] << matrix.col(b), 0.0f;
  return tensor;
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
  ratio_.resize(n), moved_.resize(n), pair_begin_.resize(n + 1);
  pair_begin_[0] = 0;
  for (std::size_t i = 0; i < n; ++i) pair_begin_[i + 1] = pair_begin_[i] + wholeLanes(near_->count(i));
  const std::size_t pairs = pair_begin_[n];
  other_.resize(pairs);
  if (any_dense_) density_gradient_.resize(3 * pairs), density_step_.resize(n);
  if (viscous_) {
    slope_.resize(pairs), own_gradient_.resize(n);
    inverse_.resize(n), weight_.resize(n), compliance_.resize(n);
    multiplier_.resize(n), strain_step_.resize(n);
  }
  parallelChunks(n, [&](std::size_t first, std::size_t last) {
    beginPairs(first, last);
    for (std::size_t i = first; viscous_ && i < last; ++i) beginViscosity(i, dt);
  });
  beginBonds(bonds);
}

/// Pairs in whole lanes: a list is filled up with pairs of the particle with itself, whose gradient is zero.
void Projection::beginPairs(std::size_t first, std::size_t last) {
  const VectorField& x = particles_->position;
  for (std::size_t i = first; i < last; ++i) {
    std::uint32_t q = pair_begin_[i];
    for (std::uint32_t p = near_->begin(i), end = p + near_->count(i); p < end; ++p, ++q)
      other_[q] = near_->other()[p];
    for (; q < pair_begin_[i + 1]; ++q) other_[q] = static_cast<std::uint32_t>(i);

    Lane total = Lane::Zero();
    Lanes own{Lane::Zero(), Lane::Zero(), Lane::Zero()};
    for (std::uint32_t p = pair_begin_[i]; p < pair_begin_[i + 1]; p += lane_width) {
      const Lanes offset = offsets(x, i, &other_[p]);
      const Lane r = offset.squaredNorm().sqrt();
      total += kernel_.value(r);
      if (!viscous_) continue;
      const Lane slope = volume_ * kernel_.slope(r) / r.max(1e-9f);
      asLane(&slope_[p]) = slope;
      own.x += slope * offset.x, own.y += slope * offset.y, own.z += slope * offset.z;
    }
    ratio_[i] = (sum(total) - kernel_.sigma * (padding(i) - 1.0f)) / lattice_sum_;
    if (viscous_) own_gradient_.set(i, {sum(own.x), sum(own.y), sum(own.z)});
  }
}

void Projection::beginViscosity(std::size_t i, float dt) {
  const float viscosity = viscosity_[particles_->material[i]];
  compliance_[i] = -1.0f;
  multiplier_[i] = strain_step_[i] = tensorOf(Eigen::Matrix3f::Zero());
  if (!(viscosity > 0.0f)) return;
  const float* w = particles_->inverse_mass.data();
  const VectorField& x = particles_->position;
  Eigen::Vector4f m[3], n[3];
  for (int b = 0; b < 3; ++b) {
    m[b].setZero();
    n[b] = w[i] * own_gradient_[i][b] * own_gradient_[i];
  }
  for (std::uint32_t p = pair_begin_[i]; p < pair_begin_[i + 1]; ++p) {
    const Eigen::Vector4f offset = x[i] - x[other_[p]];
    const Eigen::Vector4f g = slope_[p] * offset, weighted = w[other_[p]] * g;
    for (int b = 0; b < 3; ++b) {
      m[b] -= g[b] * offset;
      n[b] += g[b] * weighted;
    }
  }
  const Eigen::Matrix3f moment = matrixOf(m), weight = matrixOf(n);
  const float scale = moment.trace() / 3.0f;
  // Where the neighbours do not span space, there is no velocity gradient to damp.
  if (!(moment.determinant() > 0.02f * scale * scale * scale)) return;
  compliance_[i] = 1.0f / (2.0f * viscosity * volume_ * dt);
  const Eigen::Matrix3f inverse = moment.inverse();
  inverse_[i] = tensorOf(inverse);
  weight_[i] = tensorOf(inverse * weight * inverse.transpose());
}

void Projection::beginBonds(const Bonds* bonds) {
  bonded_ = bonds != nullptr && bonds->size() > 0;
  if (!bonded_) return;
  const std::size_t n = particles_->size();
  const auto count = [&](std::size_t i) {
    return static_cast<std::uint32_t>(bonds->end(i) - bonds->begin(i));
  };
  bond_begin_.resize(n + 1);
  bond_begin_[0] = 0;
  for (std::size_t i = 0; i < n; ++i) bond_begin_[i + 1] = bond_begin_[i] + wholeLanes(count(i));
  const std::size_t ends = bond_begin_[n];
  bond_other_.resize(ends), rest_length_.resize(ends), bond_share_.resize(ends);
  const std::vector<float>& w = particles_->inverse_mass;
  parallelFor(n, grain, [&](std::size_t i) {
    std::uint32_t b = bond_begin_[i];
    for (const Bond* bond = bonds->begin(i); bond != bonds->end(i); ++bond, ++b) {
      const std::uint32_t j = bond->other;
      const float relaxation = bond_relaxation / static_cast<float>(std::max(count(i), count(j)));
      bond_other_[b] = j, rest_length_[b] = bond->rest_length;
      bond_share_[b] = std::min(relaxation, 1.0f) * w[i] / (w[i] + w[j]);
    }
    for (; b < bond_begin_[i + 1]; ++b) {
      bond_other_[b] = static_cast<std::uint32_t>(i), rest_length_[b] = bond_share_[b] = 0.0f;
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
  const float scale = 1.0f / lattice_sum_;
  for (std::size_t i = first; i < last; ++i) {
    Lane total = Lane::Zero(), weight = Lane::Zero();
    Lanes own{Lane::Zero(), Lane::Zero(), Lane::Zero()};
    for (std::uint32_t p = pair_begin_[i], end = pair_begin_[i + 1]; p < end; p += lane_width) {
      const Lanes offset = offsets(particles_->position, u, i, &other_[p]);
      const Lane square = offset.squaredNorm(), r = square.sqrt();
      total += kernel_.value(r);
      const Lane slope = scale * kernel_.slope(r) / r.max(1e-9f);
      const Lanes g{slope * offset.x, slope * offset.y, slope * offset.z};
      asLane(&density_gradient_[3 * p]) = g.x;
      asLane(&density_gradient_[3 * p + lane_width]) = g.y;
      asLane(&density_gradient_[3 * p + 2 * lane_width]) = g.z;
      own.x += g.x, own.y += g.y, own.z += g.z;
      weight += taken(particles_->inverse_mass.data(), &other_[p]) * (slope * slope * square);
    }
    const float error = (sum(total) - kernel_.sigma * (padding(i) - 1.0f)) * scale - 1.0f;
    const Eigen::Vector3f gradient(sum(own.x), sum(own.y), sum(own.z));
    const float inertia = sum(weight) + particles_->inverse_mass[i] * gradient.squaredNorm();
    const bool pressing = error > 0.0f && inertia > 0.0f && dense_[particles_->material[i]];
    density_step_[i] = pressing ? -density_relaxation * error / inertia : 0.0f;
  }
}

void Projection::moveByDensity(VectorField& u, std::size_t first, std::size_t last) const {
  for (std::size_t i = first; i < last; ++i) {
    Lanes move{Lane::Zero(), Lane::Zero(), Lane::Zero()};
    const float own = density_step_[i];
    for (std::uint32_t p = pair_begin_[i], end = pair_begin_[i + 1]; p < end; p += lane_width) {
      const Lane step = own + taken(density_step_.data(), &other_[p]);
      move.x += step * asLane(&density_gradient_[3 * p]);
      move.y += step * asLane(&density_gradient_[3 * p + lane_width]);
      move.z += step * asLane(&density_gradient_[3 * p + 2 * lane_width]);
    }
    u.add(i, particles_->inverse_mass[i] * Eigen::Vector3f(sum(move.x), sum(move.y), sum(move.z)));
  }
}

void Projection::projectViscosity(VectorField& u) {
  parallelChunks(u.size(), [&](std::size_t first, std::size_t last) { measureStrain(u, first, last); });
  parallelChunks(u.size(), [&](std::size_t first, std::size_t last) { moveByStrain(u, first, last); });
}

void Projection::measureStrain(const VectorField& u, std::size_t first, std::size_t last) {
  const std::uint32_t* other = other_.data();
  const VectorField& x = particles_->position;
  for (std::size_t i = first; i < last; ++i) {
    if (compliance_[i] < 0.0f) continue;
    Eigen::Vector4f d0 = Eigen::Vector4f::Zero(), d1 = d0, d2 = d0;
    const Eigen::Vector4f from = u[i], at = x[i];
    for (std::uint32_t p = pair_begin_[i], end = pair_begin_[i + 1]; p < end; ++p) {
      const Eigen::Vector4f du = u[other[p]] - from;
      const Eigen::Vector4f g = slope_[p] * (at - x[other[p]]);
      d0 += g[0] * du;
      d1 += g[1] * du;
      d2 += g[2] * du;
    }
    const Tensor strain = strainOf(product(Tensor{{d0, d1, d2}}, inverse_[i]));
    const float square = dot(strain, strain);
    // |gradient of the norm of the strain|^2, by Eq. 2
    const float weight =
        square > 0.0f ? dot(product(weight_[i], strain), strain) / square : weight_[i].column[0][0];
    const float share = -viscosity_relaxation / (weight + compliance_[i]);
    Tensor step;
    for (int b = 0; b < 3; ++b) {
      step.column[b] = share * (strain.column[b] + compliance_[i] * multiplier_[i].column[b]);
      multiplier_[i].column[b] += step.column[b];
    }
    strain_step_[i] = product(step, inverse_[i]);
  }
}

void Projection::moveByStrain(VectorField& u, std::size_t first, std::size_t last) const {
  const std::uint32_t* other = other_.data();
  const VectorField& x = particles_->position;
  for (std::size_t i = first; i < last; ++i) {
    const Eigen::Vector4f &own = own_gradient_[i], at = x[i];
    const Tensor& s = strain_step_[i];
    Eigen::Vector4f m0 = own[0] * s.column[0], m1 = own[1] * s.column[1], m2 = own[2] * s.column[2];
    for (std::uint32_t p = pair_begin_[i], end = pair_begin_[i + 1]; p < end; ++p) {
      const Tensor& step = strain_step_[other[p]];
      const Eigen::Vector4f g = slope_[p] * (at - x[other[p]]);
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
    moved_[i] = u[i];
    if (!bonded_) continue;
    Lanes move{Lane::Zero(), Lane::Zero(), Lane::Zero()};
    for (std::uint32_t b = bond_begin_[i], end = bond_begin_[i + 1]; b < end; b += lane_width) {
      const Lanes offset = offsets(particles_->position, u, i, &bond_other_[b]);
      const Lane length = offset.squaredNorm().sqrt().max(1e-9f);
      const Lane share = asLane(&bond_share_[b]) * (1.0f - asLane(&rest_length_[b]) / length);
      move.x -= share * offset.x, move.y -= share * offset.y, move.z -= share * offset.z;
    }
    moved_.add(i, {sum(move.x), sum(move.y), sum(move.z)});
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
