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

using Tensor = Projection::Tensor;

/// Pairs as the loops over lanes see them.
struct Pairs {
  const std::uint32_t *begin, *end, *other;  // end: of whole lanes
  const float *x, *y, *z;                    // x_i - x_j at the start, m
};

Pairs pairsOf(const Neighbourhood& near) {
  return {near.begins(), near.paddeds(), near.other().data(), near.x(), near.y(), near.z()};
}

TACTILE_CLAY_INLINE LaneVector displacement(const float* u, std::size_t i) {
  return {all(u[4 * i]), all(u[4 * i + 1]), all(u[4 * i + 2])};
}

TACTILE_CLAY_INLINE Lane lengthOf(const LaneVector& v) {
  return root(v.x * v.x + v.y * v.y + v.z * v.z);
}

TACTILE_CLAY_INLINE Lane atLeast(const Lane& a, float least) {
  return a > least ? a : all(least);
}

TACTILE_CLAY_INLINE void sumInto(float* slot, const LaneVector& v) {
  slot[0] += sum(v.x), slot[1] += sum(v.y), slot[2] += sum(v.z);
}

/// rho / rho_0, and with `slope` V |grad W| / r of the pairs and `own`, the sums of V grad W.
TACTILE_CLAY_MULTIVERSION
void measureKernels(const Pairs& pairs, const Kernel& kernel, float volume, float lattice_sum,
                    std::size_t first, std::size_t last, float* ratio, float* slope, float* own) {
  for (std::size_t i = first; i < last; ++i) {
    Lane total{};
    LaneVector gradient{};
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width) {
      const LaneVector x{load(pairs.x + p), load(pairs.y + p), load(pairs.z + p)};
      const Lane r = lengthOf(x);
      total += kernel.value(r);
      if (slope == nullptr) continue;
      const Lane s = volume * kernel.slope(r) / atLeast(r, 1e-9f);
      store(slope + p, s);
      gradient.x += s * x.x, gradient.y += s * x.y, gradient.z += s * x.z;
    }
    ratio[i] = (sum(total) + kernel.sigma) / lattice_sum;
    if (slope == nullptr) continue;
    for (int a = 0; a < 3; ++a) own[4 * i + a] = 0.0f;
    sumInto(own + 4 * i, gradient);
  }
}

/// C_i of the density at the displacements u, its gradients by x_i of each pair (eight x, y, z in turn) and
/// sum_j w_j |gradient|^2, itself included.
TACTILE_CLAY_MULTIVERSION
void measureDensities(const Pairs& pairs, const Kernel& kernel, float lattice_sum, const float* u,
                      const float* inverse_mass, std::size_t first, std::size_t last, float* gradient,
                      float* error, float* weight) {
  const float scale = 1.0f / lattice_sum;
  for (std::size_t i = first; i < last; ++i) {
    Lane total{}, weights{};
    LaneVector own{};
    const LaneVector at = displacement(u, i);
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width) {
      const LaneVector of_other = gather(u, pairs.other + p);
      const LaneVector x{load(pairs.x + p) + (at.x - of_other.x), load(pairs.y + p) + (at.y - of_other.y),
                         load(pairs.z + p) + (at.z - of_other.z)};
      const Lane r = lengthOf(x);
      total += kernel.value(r);
      const Lane slope = scale * kernel.slope(r) / atLeast(r, 1e-9f);
      const LaneVector g{slope * x.x, slope * x.y, slope * x.z};
      store(gradient + 3 * p, g.x);
      store(gradient + 3 * p + lane_width, g.y);
      store(gradient + 3 * p + 2 * lane_width, g.z);
      own.x += g.x, own.y += g.y, own.z += g.z;
      weights += gatherNumbers(inverse_mass, pairs.other + p) * (slope * slope * (r * r));
    }
    float sums[3] = {};
    sumInto(sums, own);
    error[i] = (sum(total) + kernel.sigma) * scale - 1.0f;
    weight[i] = sum(weights) + inverse_mass[i] * (sums[0] * sums[0] + sums[1] * sums[1] + sums[2] * sums[2]);
  }
}

/// u_i += w_i sum_j (step_i + step_j) gradient_ij
TACTILE_CLAY_MULTIVERSION
void moveByDensities(const Pairs& pairs, const float* gradient, const float* step, const float* inverse_mass,
                     std::size_t first, std::size_t last, float* u) {
  for (std::size_t i = first; i < last; ++i) {
    LaneVector move{};
    const Lane own = all(step[i]);
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width) {
      const Lane both = own + gatherNumbers(step, pairs.other + p);
      move.x += both * load(gradient + 3 * p);
      move.y += both * load(gradient + 3 * p + lane_width);
      move.z += both * load(gradient + 3 * p + 2 * lane_width);
    }
    const Lane w = all(inverse_mass[i]);
    sumInto(u + 4 * i, {w * move.x, w * move.y, w * move.z});
  }
}

/// The plain sums of Eq. 4, sum_j (u_j - u_i) (V grad W)^T.
TACTILE_CLAY_MULTIVERSION
void sumGradients(const Pairs& pairs, const float* slope, const float* u, std::size_t first, std::size_t last,
                  Tensor* gradient) {
  for (std::size_t i = first; i < last; ++i) {
    LaneVector d0{}, d1{}, d2{};
    const LaneVector at = displacement(u, i);
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width) {
      const LaneVector of_other = gather(u, pairs.other + p);
      const Lane s = load(slope + p);
      const Lane x = s * (of_other.x - at.x), y = s * (of_other.y - at.y), z = s * (of_other.z - at.z);
      const Lane gx = load(pairs.x + p), gy = load(pairs.y + p), gz = load(pairs.z + p);
      d0.x += gx * x, d0.y += gx * y, d0.z += gx * z;
      d1.x += gy * x, d1.y += gy * y, d1.z += gy * z;
      d2.x += gz * x, d2.y += gz * y, d2.z += gz * z;
    }
    float* out = gradient[i].column[0].data();
    std::fill(out, out + 12, 0.0f);
    sumInto(out, d0), sumInto(out + 4, d1), sumInto(out + 8, d2);
  }
}

/// u_i -= w_i sum_j (S_i + S_j) (V grad W)
TACTILE_CLAY_MULTIVERSION
void moveByStrains(const Pairs& pairs, const float* slope, const Tensor* step, const float* own_gradient,
                   const float* inverse_mass, std::size_t first, std::size_t last, float* u) {
  for (std::size_t i = first; i < last; ++i) {
    const auto slot = [](const float* from) {
      HalfLane h;
      std::memcpy(&h, from, sizeof h);
      return h;
    };
    const float* own = step[i].column[0].data();
    const float* g = own_gradient + 4 * i;
    HalfLane m0 = g[0] * slot(own), m1 = g[1] * slot(own + 4), m2 = g[2] * slot(own + 8);
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; ++p) {
      const float* s = step[pairs.other[p]].column[0].data();
      const float weight = slope[p];
      m0 += (weight * pairs.x[p]) * slot(s);
      m1 += (weight * pairs.y[p]) * slot(s + 4);
      m2 += (weight * pairs.z[p]) * slot(s + 8);
    }
    const HalfLane at = slot(u + 4 * i) - inverse_mass[i] * (m0 + m1 + m2);
    std::memcpy(u + 4 * i, &at, sizeof at);
  }
}

/// Ends of bonds as the loop over lanes sees them.
struct BondEnds {
  const std::uint32_t *begin, *other;
  const float *rest_length, *share;
};

/// moved_i = u_i - sum_j share (l_ij - d_ij) n_ij
TACTILE_CLAY_MULTIVERSION
void pullEnds(const BondEnds& ends, const float* position, const float* u, std::size_t first,
              std::size_t last, float* moved) {
  for (std::size_t i = first; i < last; ++i) {
    LaneVector move{};
    const LaneVector from = displacement(position, i), at = displacement(u, i);
    for (std::uint32_t b = ends.begin[i]; b < ends.begin[i + 1]; b += lane_width) {
      const LaneVector other = gather(position, ends.other + b), of_other = gather(u, ends.other + b);
      // differences are formed first: they are small and exact
      const LaneVector x{(from.x - other.x) + (at.x - of_other.x), (from.y - other.y) + (at.y - of_other.y),
                         (from.z - other.z) + (at.z - of_other.z)};
      const Lane length = atLeast(lengthOf(x), 1e-9f);
      const Lane share = load(ends.share + b) * (load(ends.rest_length + b) / length - 1.0f);
      move.x += share * x.x, move.y += share * x.y, move.z += share * x.z;
    }
    std::memcpy(moved + 4 * i, u + 4 * i, 4 * sizeof(float));
    sumInto(moved + 4 * i, move);
  }
}

std::uint32_t wholeLanes(std::uint32_t count) {
  return (count + lane_width - 1) / lane_width * lane_width;
}

Eigen::Matrix3f matrixOf(const Eigen::Vector4f (&columns)[3]) {
  Eigen::Matrix3f matrix;
  matrix << columns[0].head<3>(), columns[1].head<3>(), columns[2].head<3>();
  return matrix;
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
  ratio_.resize(n), moved_.resize(n);
  if (any_dense_) {
    density_gradient_.resize(3 * near_->pairs());
    density_error_.resize(n), density_weight_.resize(n), density_step_.resize(n);
  }
  if (viscous_) {
    slope_.resize(near_->pairs()), own_gradient_.resize(n), strain_.resize(n);
    inverse_.resize(n), weight_.resize(n), compliance_.resize(n);
    multiplier_.resize(n), strain_step_.resize(n);
  }
  parallelRanges(n, grain, [&](std::size_t first, std::size_t last) {
    measureKernels(pairsOf(*near_), kernel_, volume_, lattice_sum_, first, last, ratio_.data(),
                   viscous_ ? slope_.data() : nullptr, viscous_ ? own_gradient_.data() : nullptr);
    for (std::size_t i = first; viscous_ && i < last; ++i) beginViscosity(i, dt);
  });
  beginBonds(bonds);
}

void Projection::beginViscosity(std::size_t i, float dt) {
  const float viscosity = viscosity_[particles_->material[i]];
  compliance_[i] = -1.0f;
  multiplier_[i] = strain_step_[i] = tensorOf(Eigen::Matrix3f::Zero());
  if (!(viscosity > 0.0f)) return;
  const float* w = particles_->inverse_mass.data();
  Eigen::Vector4f m[3], n[3];
  for (int b = 0; b < 3; ++b) {
    m[b].setZero();
    n[b] = w[i] * own_gradient_[i][b] * own_gradient_[i];
  }
  for (std::uint32_t p = near_->begin(i); p < near_->end(i); ++p) {
    const Eigen::Vector4f offset(near_->x()[p], near_->y()[p], near_->z()[p], 0.0f);
    const Eigen::Vector4f g = slope_[p] * offset, weighted = w[near_->other()[p]] * g;
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
  const Pairs pairs = pairsOf(*near_);
  const float* w = particles_->inverse_mass.data();
  parallelRanges(u.size(), grain, [&](std::size_t first, std::size_t last) {
    measureDensities(pairs, kernel_, lattice_sum_, u.data(), w, first, last, density_gradient_.data(),
                     density_error_.data(), density_weight_.data());
    for (std::size_t i = first; i < last; ++i) {
      const bool pressing =
          density_error_[i] > 0.0f && density_weight_[i] > 0.0f && dense_[particles_->material[i]];
      density_step_[i] = pressing ? -density_relaxation * density_error_[i] / density_weight_[i] : 0.0f;
    }
  });
  parallelRanges(u.size(), grain, [&](std::size_t first, std::size_t last) {
    moveByDensities(pairs, density_gradient_.data(), density_step_.data(), w, first, last, u.data());
  });
}

void Projection::projectViscosity(VectorField& u) {
  const Pairs pairs = pairsOf(*near_);
  parallelRanges(u.size(), grain, [&](std::size_t first, std::size_t last) {
    sumGradients(pairs, slope_.data(), u.data(), first, last, strain_.data());
    for (std::size_t i = first; i < last; ++i) resistStrain(i);
  });
  parallelRanges(u.size(), grain, [&](std::size_t first, std::size_t last) {
    moveByStrains(pairs, slope_.data(), strain_step_.data(), own_gradient_.data(),
                  particles_->inverse_mass.data(), first, last, u.data());
  });
}

/// The step of the multiplier of a particle's strain.
void Projection::resistStrain(std::size_t i) {
  if (compliance_[i] < 0.0f) return;
  const Tensor strain = strainOf(product(strain_[i], inverse_[i]));
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

void Projection::projectBondsAndContacts(VectorField& u, std::vector<Contact>& contacts) {
  const BondEnds ends{bond_begin_.data(), bond_other_.data(), rest_length_.data(), bond_share_.data()};
  parallelRanges(u.size(), grain, [&](std::size_t first, std::size_t last) {
    if (bonded_) {
      pullEnds(ends, particles_->position.data(), u.data(), first, last, moved_.data());
    } else {
      for (std::size_t i = first; i < last; ++i) moved_[i] = u[i];
    }
    for (std::uint32_t c = contact_begin_[first]; c < contact_begin_[last]; ++c) {
      Eigen::Vector3f step = moved_.at(contacts[c].particle);
      projectContact(contacts[c], step);
      moved_.set(contacts[c].particle, step);
    }
  });
  std::swap(u, moved_);
}

void Projection::projectContact(Contact& c, Eigen::Vector3f& u) const {
  const float depth = c.gap - c.normal.dot(u);
  if (!(depth > 0.0f)) return;
  const std::uint32_t i = c.particle;
  u += depth * c.normal;
  c.state = Contact::State::slide;

  const float mu = (c.solid == Contact::skin ? skin_friction_ : friction_)[particles_->material[i]];
  Eigen::Vector3f pull = c.anchor - u;
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
    c.anchor -= u.at(c.particle);
    if (c.state == Contact::State::open) continue;
    const float moved = c.friction.norm() * particles_->inverse_mass[c.particle] / force_per_kg_m_;
    c.anchor -= c.anchor.dot(c.normal) * c.normal;
    const float distance = c.anchor.norm();
    if (distance > moved) c.anchor *= moved / distance;
  }
}

}  // namespace tactile_clay::clay
