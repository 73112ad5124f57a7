#include "clay/projection.h"

#include <algorithm>
#include <cmath>

#include "clay/lattice.h"
#include "clay/threads.h"
#include "lanes/lane_matrix.h"
#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

constexpr std::size_t grain = 128;  // whole lanes

// Shares of full corrections; each is near the largest with which a block comes to rest.
constexpr float density_relaxation = 0.25f;
constexpr float viscosity_relaxation = 0.125f;
constexpr float bond_relaxation = 1.3f;  // over the greater number of bonds of the two ends
// So that no distance is zero. Its square is added to squares, and lost in rounding beyond 10 um.
constexpr float tiny_distance = 1e-9f, tiny = tiny_distance * tiny_distance;  // m, m^2

using Viscosity = Projection::Viscosity;
using BondEnds = Projection::BondEnds;

/// Pairs as the loops over lanes see them. They get it by value: no store may change it then.
struct Pairs {
  const std::uint32_t *begin, *end, *slot;  // end: of whole lanes; slot of j
  const float *x, *y, *z, *distance;        // x_i - x_j at the start, and its norm, m
};

Pairs pairsOf(const Neighbourhood& near) {
  return {near.begins(), near.paddeds(), near.slots(), near.x(), near.y(), near.z(), near.distances()};
}

std::size_t wholeLanes(std::size_t count) {
  return (count + lane_width - 1) / lane_width * lane_width;
}

/// Gradients of pairs: eight x, eight y and eight z in turn.
TACTILE_CLAY_INLINE LaneVector loadGradient(const float* gradient, std::uint32_t p) {
  const float* at = gradient + 3 * std::size_t{p};
  return {load(at), load(at + lane_width), load(at + 2 * lane_width)};
}
TACTILE_CLAY_INLINE void storeGradient(float* gradient, std::uint32_t p, const LaneVector& g) {
  float* at = gradient + 3 * std::size_t{p};
  store(at, g.x), store(at + lane_width, g.y), store(at + 2 * lane_width, g.z);
}

/// rho / rho_0
TACTILE_CLAY_MULTIVERSION
void measureRatios(const Pairs pairs, const Kernel& kernel, float lattice_sum, std::size_t first,
                   std::size_t last, float* ratio) {
  for (std::size_t i = first; i < last; ++i) {
    Lane total{};
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width)
      total += kernel.value(load(pairs.distance + p));
    ratio[i] = (sum(total) + kernel.sigma) / lattice_sum;
  }
}

/// V grad W of the pairs, its sums, and of each eight particles from `first` on what the constraint needs.
TACTILE_CLAY_MULTIVERSION
void beginStrains(const Pairs pairs, const Kernel& kernel, float volume, const float* inverse_mass,
                  const float* compliance, std::size_t first, std::size_t last, float* gradient, float* own,
                  Viscosity* viscosity) {
  for (std::size_t i = first; i < last; i += lane_width) {
    Totals<Symmetric> moments(last - i), weights(last - i);
    for (int k = 0; k < lane_width && i + k < last; ++k) {
      LaneVector total{};
      Symmetric moment{}, weight{};
      for (std::uint32_t p = pairs.begin[i + k]; p < pairs.end[i + k]; p += lane_width) {
        const LaneVector x = loadVector(pairs.x, pairs.y, pairs.z, p);
        const Lane r = greatest(load(pairs.distance + p), all(tiny_distance));
        const LaneVector g = times(kernel.slope(r) * (volume / r), x);
        storeGradient(gradient, p, g);
        add(total, g);
        addOuter(moment, g, x);
        addOuter(weight, times(gatherNumbers(inverse_mass, pairs.slot + p), g), g);
      }
      storeSlot(own + 4 * (i + k), sums(total));
      moments.set(k, moment), weights.set(k, weight);
    }
    LaneVector total{};
    for (int k = 0; k < lane_width && i + k < last; ++k) {
      total.x[k] = own[4 * (i + k)], total.y[k] = own[4 * (i + k) + 1], total.z[k] = own[4 * (i + k) + 2];
    }
    Symmetric weight = weights.get();
    addOuter(weight, times(load(inverse_mass + i), total), total);
    const Symmetric m = times(all(-1.0f), moments.get());
    const Symmetric cofactors{m.yy * m.zz - m.yz * m.yz, m.xx * m.zz - m.zx * m.zx,
                              m.xx * m.yy - m.xy * m.xy, m.xy * m.zx - m.xx * m.yz,
                              m.xy * m.yz - m.yy * m.zx, m.yz * m.zx - m.zz * m.xy};
    const Lane determinant = m.xx * cofactors.xx + m.xy * cofactors.xy + m.zx * cofactors.zx;
    const Lane scale = (m.xx + m.yy + m.zz) / 3.0f, wanted = load(compliance + i);
    // Where the neighbours do not span space, there is no velocity gradient to damp.
    const LaneOrder spans = (determinant > 0.02f * scale * scale * scale) & (wanted >= 0.0f);
    Viscosity& v = viscosity[i / lane_width];
    v.compliance = spans ? wanted : all(-1.0f);
    v.inverse = where(spans, times(1.0f / determinant, cofactors));
    const Columns inverse = columnsOf(v.inverse);
    v.weight = upperOf(times(inverse, times(columnsOf(weight), inverse)));
    v.multiplier = Symmetric{};
  }
}

/// C_i of the density at the displacements u, its gradients by x_i of each pair, and the multipliers' steps.
/// \param u its fourth numbers are inverse masses \param share of a full correction
TACTILE_CLAY_MULTIVERSION
void measureDensities(const Pairs pairs, const Kernel& kernel, float lattice_sum, const float* u,
                      const float* inverse_mass, const float* share, std::size_t first, std::size_t last,
                      float* gradient, float* step) {
  const float scale = 1.0f / lattice_sum, steepest = kernel.steepest() * scale;
  struct Measured {
    Lane density, weight;  // of 2 sigma; sum_j w_j |gradient|^2, of steepest^2
    LaneVector gradient;
  };
  for (std::size_t i = first; i < last; i += lane_width) {
    Totals<Measured> totals(last - i);
    for (int k = 0; k < lane_width && i + k < last; ++k) {
      Measured total{};
      const LaneVector at = allOf(u + 4 * (i + k));
      for (std::uint32_t p = pairs.begin[i + k]; p < pairs.end[i + k]; p += lane_width) {
        Lane w;
        const LaneVector of_other = gather(u, pairs.slot + p, w);
        const LaneVector x{load(pairs.x + p) + (at.x - of_other.x), load(pairs.y + p) + (at.y - of_other.y),
                           load(pairs.z + p) + (at.z - of_other.z)};
        const Lane r = root(dot(x, x) + tiny);
        const auto shape = kernel.shape(r);
        const LaneVector g = times(shape.slope * (steepest / r), x);
        storeGradient(gradient, p, g);
        add(total.gradient, g);
        total.density += shape.value;
        total.weight += w * (shape.slope * shape.slope);
      }
      totals.set(k, total);
    }
    const Measured total = totals.get();
    const Lane error = (2.0f * total.density + 1.0f) * (kernel.sigma * scale) - 1.0f;
    const Lane weight =
        steepest * steepest * total.weight + load(inverse_mass + i) * dot(total.gradient, total.gradient);
    const LaneOrder pressing = (error > 0.0f) & (weight > 0.0f);
    store(step + i, pressing ? -load(share + i) * error / weight : Lane{});
  }
}

/// u_i += w_i sum_j (step_i + step_j) gradient_ij
TACTILE_CLAY_MULTIVERSION
void moveByDensities(const Pairs pairs, const float* gradient, const float* step, std::size_t first,
                     std::size_t last, float* u) {
  for (std::size_t i = first; i < last; ++i) {
    LaneVector move{};
    const Lane own = all(step[i]);
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width)
      add(move, times(own + gatherNumbers(step, pairs.slot + p), loadGradient(gradient, p)));
    storeSlot(u + 4 * i, slot(u + 4 * i) + u[4 * i + 3] * sums(move));
  }
}

/// sym(gradient - R) with R the rotation whose antisymmetric part is that of the gradient, I + grad u^r.
TACTILE_CLAY_INLINE Symmetric strainOf(const Columns& gradient) {
  const LaneVector &a = gradient.x, &b = gradient.y, &c = gradient.z;
  // axis times sine of the angle
  const LaneVector turn{0.5f * (b.z - c.y), 0.5f * (c.x - a.z), 0.5f * (a.y - b.x)};
  const Lane cosine = root(positive(1.0f - dot(turn, turn))), bend = 1.0f / (1.0f + cosine);
  const LaneVector bent = times(bend, turn);
  const Lane stretch = 1.0f - cosine;
  return {a.x - bent.x * turn.x + stretch,      b.y - bent.y * turn.y + stretch,
          c.z - bent.z * turn.z + stretch,      0.5f * (c.y + b.z) - bent.y * turn.z,
          0.5f * (a.z + c.x) - bent.z * turn.x, 0.5f * (b.x + a.y) - bent.x * turn.y};
}

/// The steps of the multipliers of the strains of eight particles, corrected.
/// \param plain sums of Eq. 4, not corrected
TACTILE_CLAY_INLINE Columns resistStrains(const Columns& plain, Viscosity& v) {
  const Columns inverse = columnsOf(v.inverse);
  const Symmetric strain = strainOf(times(plain, inverse));
  const Columns columns = columnsOf(strain);
  const Lane square = dot(columns, columns);
  // |gradient of the norm of the strain|^2, by Eq. 2
  const Lane weight =
      square > 0.0f ? dot(times(columnsOf(v.weight), columns), columns) / square : v.weight.xx;
  const Lane share = v.compliance >= 0.0f ? -viscosity_relaxation / (weight + v.compliance) : Lane{};
  const Symmetric step = times(share, sum(strain, times(v.compliance, v.multiplier)));
  v.multiplier = sum(v.multiplier, step);
  return times(columnsOf(step), inverse);
}

/// The multipliers' steps at the displacements u. \param step_xy eight numbers a particle: their columns x
/// and y \param step_z four numbers a particle: their columns z
TACTILE_CLAY_MULTIVERSION
void measureStrains(const Pairs pairs, const float* gradient, const float* u, std::size_t first,
                    std::size_t last, Viscosity* viscosity, float* step_xy, float* step_z) {
  for (std::size_t i = first; i < last; i += lane_width) {
    Totals<Columns> totals(last - i);  // of Eq. 4, sum_j (u_j - u_i) (V grad W)^T
    for (int k = 0; k < lane_width && i + k < last; ++k) {
      Columns total{};
      const LaneVector at = allOf(u + 4 * (i + k));
      for (std::uint32_t p = pairs.begin[i + k]; p < pairs.end[i + k]; p += lane_width) {
        const LaneVector of_other = gather(u, pairs.slot + p), g = loadGradient(gradient, p);
        const LaneVector to_other{of_other.x - at.x, of_other.y - at.y, of_other.z - at.z};
        add(total.x, times(g.x, to_other));
        add(total.y, times(g.y, to_other));
        add(total.z, times(g.z, to_other));
      }
      totals.set(k, total);
    }
    const Columns steps = resistStrains(totals.get(), viscosity[i / lane_width]);
    scatter(steps.x, step_xy + 8 * i, 8);
    scatter(steps.y, step_xy + 8 * i + 4, 8);
    scatter(steps.z, step_z + 4 * i, 4);
  }
}

/// Adds S_j g of pairs k and k + 4 of eight: columns x and y of each pair, and z of both.
template <int k>
TACTILE_CLAY_INLINE void addSteps(const float* step_xy, const float* step_z, const std::uint32_t* slots,
                                  const Lane& low_xy, const Lane& high_xy, const Lane& z, Lane (&sum_xy)[2],
                                  Lane& sum_z) {
  const std::size_t low = slots[k], high = slots[k + 4];
  sum_xy[0] += spread<k>(low_xy) * load(step_xy + 2 * low);
  sum_xy[1] += spread<k>(high_xy) * load(step_xy + 2 * high);
  sum_z += spread<k>(z) * join(slot(step_z + low), slot(step_z + high));
}

/// u_i -= w_i sum_j (S_i + S_j) (V grad W). \param step_xy eight numbers a particle, columns x and y of S
/// \param step_z four numbers a particle, column z
TACTILE_CLAY_MULTIVERSION
void moveByStrains(const Pairs pairs, const float* gradient, const float* step_xy, const float* step_z,
                   const float* own_gradient, std::size_t first, std::size_t last, float* u) {
  for (std::size_t i = first; i < last; ++i) {
    const float* total = own_gradient + 4 * i;
    // Sums in turn, so that none waits for the other.
    Lane xy[2] = {join(total[0] * slot(step_xy + 8 * i), total[1] * slot(step_xy + 8 * i + 4))};
    Lane z = join(total[2] * slot(step_z + 4 * i), HalfLane{});
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width) {
      const float* g = gradient + 3 * std::size_t{p};
      const Lane low_xy = join(slot(g), slot(g + lane_width));
      const Lane high_xy = join(slot(g + 4), slot(g + lane_width + 4)), g_z = load(g + 2 * lane_width);
      const std::uint32_t* slots = pairs.slot + p;
      addSteps<0>(step_xy, step_z, slots, low_xy, high_xy, g_z, xy, z);
      addSteps<1>(step_xy, step_z, slots, low_xy, high_xy, g_z, xy, z);
      addSteps<2>(step_xy, step_z, slots, low_xy, high_xy, g_z, xy, z);
      addSteps<3>(step_xy, step_z, slots, low_xy, high_xy, g_z, xy, z);
    }
    storeSlot(u + 4 * i, slot(u + 4 * i) - u[4 * i + 3] * sumOfHalves(xy[0] + xy[1] + z));
  }
}

/// \param pair_rest_length zero: not bonded \param relaxation of the bonds of each particle
TACTILE_CLAY_MULTIVERSION
void listBonds(const Pairs pairs, const float* pair_rest_length, const float* relaxation,
               const float* inverse_mass, std::size_t first, std::size_t last, const BondEnds& ends) {
  for (std::size_t i = first; i < last; ++i) {
    std::uint32_t b = pairs.begin[i];
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width) {
      const Lane rest_length = load(pair_rest_length + p);
      const unsigned mask = bits(rest_length > 0.0f);
      const LaneOrder& order = selections.order[mask];
      const std::uint32_t* slot = pairs.slot + p;
      const Lane share = least(all(relaxation[i]), gatherNumbers(relaxation, slot)) * inverse_mass[i] /
                         (inverse_mass[i] + gatherNumbers(inverse_mass, slot));
      store(ends.slot + b, select(load(slot), order));
      store(ends.x + b, select(load(pairs.x + p), order));
      store(ends.y + b, select(load(pairs.y + p), order));
      store(ends.z + b, select(load(pairs.z + p), order));
      store(ends.rest_length + b, select(rest_length, order));
      store(ends.share + b, select(share, order));
      b += selections.count[mask];
    }
    for (; (b - pairs.begin[i]) % lane_width != 0; ++b) {
      ends.slot[b] = static_cast<std::uint32_t>(slot_size * i);
      ends.x[b] = ends.y[b] = ends.z[b] = ends.rest_length[b] = ends.share[b] = 0.0f;
    }
    ends.end[i] = b;
  }
}

/// moved_i = u_i - sum_j share (l_ij - d_ij) n_ij
TACTILE_CLAY_MULTIVERSION
void pullEnds(const std::uint32_t* begin, const BondEnds& ends, const float* u, std::size_t first,
              std::size_t last, float* moved) {
  for (std::size_t i = first; i < last; ++i) {
    LaneVector move{};
    const LaneVector at = allOf(u + 4 * i);
    for (std::uint32_t b = begin[i]; b < ends.end[i]; b += lane_width) {
      const LaneVector of_other = gather(u, ends.slot + b);
      const LaneVector x{load(ends.x + b) + (at.x - of_other.x), load(ends.y + b) + (at.y - of_other.y),
                         load(ends.z + b) + (at.z - of_other.z)};
      const Lane length = root(dot(x, x) + tiny);
      add(move, times(load(ends.share + b) * (load(ends.rest_length + b) / length - 1.0f), x));
    }
    storeSlot(moved + 4 * i, slot(u + 4 * i) + sums(move));
  }
}

/// \param u gets its first three numbers changed
TACTILE_CLAY_INLINE void projectTouch(Projection::Touch& touch, Eigen::Vector4f& u) {
  Eigen::Vector3f moved = u.head<3>();
  const float depth = touch.gap - touch.normal.dot(moved);
  if (!(depth > 0.0f)) return;
  moved += depth * touch.normal;
  Eigen::Vector3f pull = touch.anchor - moved;
  pull -= pull.dot(touch.normal) * touch.normal;
  const float square = pull.squaredNorm(), limit = touch.friction * depth;
  if (square > limit * limit) pull *= limit / std::sqrt(square);
  u.head<3>() = moved + pull;
  touch.pushed += depth, touch.pulled += pull;
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
  begin(bonds, free, dt);
  beginContacts(contacts.contacts());
  for (int k = 0; k < iterations; ++k) {
    if (any_dense_) projectDensity();
    if (viscous_) projectViscosity();
    projectBondsAndContacts();
  }
  u.resize(particles.size());
  parallelRanges(u.size(), grain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) u.set(i, u_.at(i));
  });
  endContacts(dt, contacts.contacts());
}

void Projection::begin(const Bonds* bonds, const VectorField& free, float dt) {
  const std::size_t n = particles_->size(), whole = wholeLanes(n), pairs = near_->pairs();
  bonded_ = bonds != nullptr && bonds->size() > 0;
  ratio_.resize(n), u_.resize(n), moved_.resize(n);
  inverse_mass_.resize(whole);
  if (any_dense_)
    density_gradient_.resize(3 * pairs), density_share_.resize(whole), density_step_.resize(whole);
  if (viscous_) {
    gradient_.resize(3 * pairs), own_gradient_.resize(n), compliance_.resize(whole);
    viscosities_.resize(whole / lane_width);
    strain_step_xy_.resize(8 * whole), strain_step_z_.resize(4 * whole);
  }
  if (bonded_) {
    bond_relaxation_.resize(n), bond_end_.resize(n), bond_slot_.resize(pairs);
    for (auto* numbers : {&bond_x_, &bond_y_, &bond_z_, &rest_length_, &bond_share_}) numbers->resize(pairs);
  }
  parallelRanges(whole, grain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) beginParticle(i, bonds, free, dt);
  });
  parallelRanges(n, grain, [&](std::size_t first, std::size_t last) {
    measureRatios(pairsOf(*near_), kernel_, lattice_sum_, first, last, ratio_.data());
    if (viscous_) {
      beginStrains(pairsOf(*near_), kernel_, volume_, inverse_mass_.data(), compliance_.data(), first, last,
                   gradient_.data(), own_gradient_.data(), viscosities_.data());
    }
    if (bonded_) {
      listBonds(pairsOf(*near_), bonds->restLengths().data(), bond_relaxation_.data(), inverse_mass_.data(),
                first, last, bondEnds());
    }
  });
}

/// What no pair has part in; beyond the last particle, what lets whole lanes be read.
void Projection::beginParticle(std::size_t i, const Bonds* bonds, const VectorField& free, float dt) {
  const bool is = i < particles_->size();
  const std::uint8_t material = is ? particles_->material[i] : 0;
  inverse_mass_[i] = is ? particles_->inverse_mass[i] : 0.0f;
  if (any_dense_) density_share_[i] = is && dense_[material] ? density_relaxation : 0.0f;
  if (viscous_) {
    const float viscosity = is ? viscosity_[material] : 0.0f;
    compliance_[i] = viscosity > 0.0f ? 1.0f / (2.0f * viscosity * volume_ * dt) : -1.0f;
  }
  if (!is) return;
  u_[i] = free[i];
  u_[i][3] = inverse_mass_[i];
  if (bonded_) {
    const auto count = static_cast<float>(bonds->end(i) - bonds->begin(i));
    bond_relaxation_[i] = std::min(bond_relaxation / std::max(count, 1.0f), 1.0f);
  }
}

void Projection::beginContacts(const std::vector<Contact>& contacts) {
  contact_begin_.assign(particles_->size() + 1, 0);
  for (const Contact& c : contacts) ++contact_begin_[c.particle + 1];
  for (std::size_t i = 0; i < particles_->size(); ++i) contact_begin_[i + 1] += contact_begin_[i];
  touches_.resize(contacts.size());
  parallelRanges(contacts.size(), grain, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const Contact& c = contacts[k];
      const std::vector<float>& friction = c.solid == Contact::skin ? skin_friction_ : friction_;
      touches_[k] = {c.particle,
                     c.gap,
                     c.normal,
                     c.anchor,
                     friction[particles_->material[c.particle]],
                     0.0f,
                     Eigen::Vector3f::Zero()};
    }
  });
}

void Projection::projectDensity() {
  const Pairs pairs = pairsOf(*near_);
  parallelRanges(u_.size(), grain, [&](std::size_t first, std::size_t last) {
    measureDensities(pairs, kernel_, lattice_sum_, u_.data(), inverse_mass_.data(), density_share_.data(),
                     first, last, density_gradient_.data(), density_step_.data());
  });
  parallelRanges(u_.size(), grain, [&](std::size_t first, std::size_t last) {
    moveByDensities(pairs, density_gradient_.data(), density_step_.data(), first, last, u_.data());
  });
}

void Projection::projectViscosity() {
  const Pairs pairs = pairsOf(*near_);
  parallelRanges(u_.size(), grain, [&](std::size_t first, std::size_t last) {
    measureStrains(pairs, gradient_.data(), u_.data(), first, last, viscosities_.data(),
                   strain_step_xy_.data(), strain_step_z_.data());
  });
  parallelRanges(u_.size(), grain, [&](std::size_t first, std::size_t last) {
    moveByStrains(pairs, gradient_.data(), strain_step_xy_.data(), strain_step_z_.data(),
                  own_gradient_.data(), first, last, u_.data());
  });
}

void Projection::projectBondsAndContacts() {
  parallelRanges(u_.size(), grain, [&](std::size_t first, std::size_t last) {
    if (bonded_) {
      pullEnds(near_->begins(), bondEnds(), u_.data(), first, last, moved_.data());
    } else {
      for (std::size_t i = first; i < last; ++i) moved_[i] = u_[i];
    }
    for (std::uint32_t c = contact_begin_[first]; c < contact_begin_[last]; ++c)
      projectTouch(touches_[c], moved_[touches_[c].particle]);
  });
  std::swap(u_, moved_);
}

/// Sets what the contacts bore. An anchor is left behind by no more than the friction of the step moved the
/// particle.
void Projection::endContacts(float dt, std::vector<Contact>& contacts) const {
  parallelRanges(contacts.size(), grain, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      Contact& c = contacts[k];
      const Touch& touch = touches_[k];
      const float force_per_metre = 1.0f / (dt * dt * particles_->inverse_mass[c.particle]);
      c.state = touch.pushed > 0.0f ? Contact::State::slide : Contact::State::open;
      c.friction = force_per_metre * touch.pulled;
      c.force = c.friction + force_per_metre * touch.pushed * c.normal;
      c.anchor -= u_.at(c.particle);
      if (c.state == Contact::State::open) continue;
      c.anchor -= c.anchor.dot(c.normal) * c.normal;
      const float distance = c.anchor.norm(), moved = touch.pulled.norm();
      if (distance > moved) c.anchor *= moved / distance;
    }
  });
}

}  // namespace tactile_clay::clay
