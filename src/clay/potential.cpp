#include "clay/potential.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "clay/lattice.h"
#include "clay/threads.h"
#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

constexpr float recovery_speed = 0.5f;   // m/s, of compression that nothing did work for
constexpr float forgiven_speed = 0.1f;   // m/s, of the energy that a particle is given in a step
constexpr float slowest = 0.1f;          // 1/s, shear rate below which a viscosity no longer grows
constexpr float recovery_share = 0.25f;  // of it at a time, since neighbours undo each other's too

// Loops get what they read by value: no store may change it then.
using Pairs = PairArrays;

// Particles whose pairs the last cache of usual processors still holds; asking ahead for these costs a tenth.
constexpr std::size_t few = 1u << 15u;

/// Asks for what a loop over many pairs reads next but some: the processor foresees no more than a page of an
/// array.
template <typename Number>
TACTILE_CLAY_INLINE void fetchAhead(const Pairs& pairs, const Number* numbers, std::uint32_t p) {
  constexpr std::size_t ahead = 256;
  if (pairs.many) __builtin_prefetch(numbers + p + ahead);
}
TACTILE_CLAY_INLINE LaneVector loadGradient(const Pairs& pairs, std::uint32_t p) {
  fetchAhead(pairs, pairs.slot, p);
  for (const float* along : {pairs.x, pairs.y, pairs.z}) fetchAhead(pairs, along, p);
  return loadVector(pairs.x, pairs.y, pairs.z, p);
}

/// Displacements, and what they do to the particles: forces of the springs, growth of C.
struct Stretch {
  const float* u;
  float *f, *growth;
};

/// Forces of the springs, or the growth of C, or both, of particles [first, last), for each of some
/// displacements. Where there are many pairs, it is reading them that takes the time.
template <bool springs, bool density, int count>
TACTILE_CLAY_INLINE void stretch(const Pairs pairs, const Stretch (&all_of)[count], std::size_t first,
                                 std::size_t last) {
  for (std::size_t i = first; i < last; ++i) {
    LaneVector own[count], forces[count]{};
    Lane total[count]{};
    for (int k = 0; k < count; ++k) own[k] = allOf(all_of[k].u + slot_size * i);
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width) {
      const LaneVector g = loadGradient(pairs, p);
      if (springs) fetchAhead(pairs, pairs.spring, p);
      for (int k = 0; k < count; ++k) {
        const Lane along = dot(g, difference(gather(all_of[k].u, pairs.slot + p), own[k]));
        if (density) total[k] += along;
        if (springs) add(forces[k], times(load(pairs.spring + p) * along, g));
      }
    }
    for (int k = 0; k < count; ++k) {
      HalfLane both = sums(forces[k], total[k]);
      if (density) all_of[k].growth[i] = both[3];
      both[3] = 0.0f;
      storeSlot(all_of[k].f + slot_size * i, both);
    }
  }
}
TACTILE_CLAY_MULTIVERSION
void stretchSprings(const Pairs pairs, const Stretch one, std::size_t first, std::size_t last) {
  stretch<true, false>(pairs, {one}, first, last);
}
TACTILE_CLAY_MULTIVERSION
void stretchDensity(const Pairs pairs, const Stretch one, std::size_t first, std::size_t last) {
  stretch<false, true>(pairs, {one}, first, last);
}
TACTILE_CLAY_MULTIVERSION
void stretchBoth(const Pairs pairs, const Stretch one, std::size_t first, std::size_t last) {
  stretch<true, true>(pairs, {one}, first, last);
}
TACTILE_CLAY_MULTIVERSION
void stretchBothTwice(const Pairs pairs, const Stretch one, const Stretch other, std::size_t first,
                      std::size_t last) {
  stretch<true, true>(pairs, {one, other}, first, last);
}

/// Pressures times volume, J, and the forces they are added to.
struct Press {
  const float* pressure;
  float* f;
};

/// Adds the forces of pressures: sum_j (P_i + P_j) g, for each of some sets of pressures. `squeezed` tells
/// where there are any; `find` finds that out, from the first set.
template <bool find, int count, typename Flags>
TACTILE_CLAY_INLINE void pressInto(const Pairs pairs, const Press (&all_of)[count], std::size_t first,
                                   std::size_t last, Flags* squeezed) {
  for (std::size_t i = first; i < last; ++i) {
    if (!find && squeezed[i] == 0) continue;
    Lane own[count];
    LaneVector forces[count]{};
    for (int k = 0; k < count; ++k) own[k] = all(all_of[k].pressure[i]);
    Lane most = own[0];
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width) {
      const LaneVector g = loadGradient(pairs, p);
      for (int k = 0; k < count; ++k) {
        const Lane of_others = gatherNumbers(all_of[k].pressure, pairs.slot + p);
        if (find && k == 0) most = most > of_others ? most : of_others;
        add(forces[k], times(own[k] + of_others, g));
      }
    }
    if constexpr (find) squeezed[i] = bits(most > 0.0f) != 0;
    for (int k = 0; k < count; ++k) {
      float* f = all_of[k].f + slot_size * i;
      storeSlot(f, slot(f) + sums(forces[k]));
    }
  }
}
TACTILE_CLAY_MULTIVERSION
void findPressed(const Pairs pairs, const Press one, std::size_t first, std::size_t last,
                 std::uint8_t* squeezed) {
  pressInto<true>(pairs, {one}, first, last, squeezed);
}
TACTILE_CLAY_MULTIVERSION
void findPressedTwice(const Pairs pairs, const Press one, const Press other, std::size_t first,
                      std::size_t last, std::uint8_t* squeezed) {
  pressInto<true>(pairs, {one, other}, first, last, squeezed);
}
TACTILE_CLAY_MULTIVERSION
void pressPairs(const Pairs pairs, const Press one, std::size_t first, std::size_t last,
                const std::uint8_t* squeezed) {
  pressInto<false>(pairs, {one}, first, last, squeezed);
}

/// Stiffness of a dashpot over x x^T falls with the distance like this: (1 - q^2)^3, q = r / h. With it the
/// initial lattice is isotropic within 5 %, which it is far from with the usual -W'/r^3.
/// \param per_square 1 / h^2
TACTILE_CLAY_INLINE Lane dashpotWeight(float per_square, const Lane& square) {
  const Lane a = positive(1.0f - square * per_square);
  return a * a * a;
}

/// Pairs as they are at the start of the step.
struct Surroundings {
  const std::uint32_t *begin, *end, *slot;
  const float *x, *y, *z, *distance;  // m
};

struct Setup {
  Surroundings pairs;
  Kernel kernel;
  float lattice_sum;       // 1/m^3
  float lattice_dashpots;  // m^4
  const float* guess;
  const std::uint8_t* material;  // per particle
  std::size_t materials;
  const float* dashpot;      // N/m^3, of a displacement in the step, for each two materials
  const Bonds* bonds;        // or null
  const float* rest_length;  // of the bonds, per pair
  const float* secant;       // of the stiffness of the bonds of each particle, see Flow; or null
  bool dense, sprung;
  float *x, *y, *z, *spring;         // per pair, see PairArrays
  float *ratio, *amend, *steepness;  // per particle
  float *force, *excess;             // per particle
};

/// Of particles [first, last): rho / rho_0, and how much stronger dashpots are for those that a surface takes
/// away. Of their pairs: the gradients g, and g over x where the springs will be.
TACTILE_CLAY_MULTIVERSION
void measureSurroundings(const Setup s, std::size_t first, std::size_t last) {
  // The compiler may not take these out of the loop.
  const float per_lattice_sum = 1.0f / s.lattice_sum, per_square = 1.0f / (s.kernel.h * s.kernel.h);
  const Lane shortest = all(1e-4f * s.kernel.h);
  // So that springs can be told per square of a gradient; C does not notice.
  const Lane least_compression = all(1e-8f * per_square);
  for (std::size_t i = first; i < last; ++i) {
    Lane density{}, dashpots{}, steepness{};
    for (std::uint32_t p = s.pairs.begin[i]; p < s.pairs.end[i]; p += lane_width) {
      const Lane r = load(s.pairs.distance + p), square = r * r;
      density += s.kernel.value(r);
      dashpots += dashpotWeight(per_square, square) * square * square;
      if (!s.dense) continue;
      const Lane compression =
          greatest(-s.kernel.slope(r) * per_lattice_sum / greatest(r, shortest), least_compression);
      const LaneVector g = times(compression, loadVector(s.pairs.x, s.pairs.y, s.pairs.z, p));
      store(s.x + p, g.x), store(s.y + p, g.y), store(s.z + p, g.z), store(s.spring + p, compression);
      steepness += dot(g, g);
    }
    s.steepness[i] = std::sqrt(sum(steepness));
    s.ratio[i] = (sum(density) + s.kernel.sigma) * per_lattice_sum;
    // A particle at a surface has fewer pairs, but no less clay.
    s.amend[i] = 1.0f / std::max(sum(dashpots) / s.lattice_dashpots, 0.25f);
  }
}

/// Viscosity that thins with the shear rate, Herschel & Bulkley's eta rate^(n - 1), of particles [first,
/// last). Their rate is the one at which a Newtonian fluid would dissipate what the dashpots do at the guess:
/// for an isotropic fluid, sum_j w (x.v)^2 = rate^2 sum_j w r^4 / 15. \param flow_index n of each material
/// \param dt s
TACTILE_CLAY_MULTIVERSION
void thinDashpots(const Setup s, const float* flow_index, float dt, std::size_t first, std::size_t last) {
  const float per_square = 1.0f / (s.kernel.h * s.kernel.h);
  for (std::size_t i = first; i < last; ++i) {
    const float n = flow_index[s.material[i]];
    if (n == 1.0f) continue;
    const LaneVector guess = allOf(s.guess + slot_size * i);
    Lane squares{};
    for (std::uint32_t p = s.pairs.begin[i]; p < s.pairs.end[i]; p += lane_width) {
      const LaneVector x = loadVector(s.pairs.x, s.pairs.y, s.pairs.z, p);
      const Lane r = load(s.pairs.distance + p);
      const Lane along = dot(x, difference(gather(s.guess, s.pairs.slot + p), guess));
      squares += dashpotWeight(per_square, r * r) * along * along;
    }
    const float rate = std::sqrt(15.0f * s.amend[i] * sum(squares) / s.lattice_dashpots) / dt;
    s.amend[i] *= std::pow(std::max(rate, slowest), n - 1.0f);
  }
}

/// Springs and density of particles [first, last).
template <bool alike>
TACTILE_CLAY_INLINE void linearise(const Setup s, std::size_t first, std::size_t last) {
  const Kernel& kernel = s.kernel;
  const float per_square = 1.0f / (kernel.h * kernel.h);
  const Lane shortest = all(1e-8f * kernel.h * kernel.h);
  for (std::size_t i = first; i < last; ++i) {
    const LaneVector guess = allOf(s.guess + slot_size * i);
    const Lane own = all(s.amend[i]);
    const float* dashpots = s.dashpot + s.material[i] * s.materials;
    const BondRule* rules = s.bonds != nullptr ? s.bonds->rules(s.material[i]) : nullptr;
    Lane damping = all(dashpots[0]), stiffness = all(rules != nullptr ? rules->stiffness : 0.0f);
    const Lane own_secant = all(rules != nullptr ? s.secant[i] : 0.0f);
    LaneVector forces{};
    Lane guessed{}, lag{};
    for (std::uint32_t p = s.pairs.begin[i]; p < s.pairs.end[i]; p += lane_width) {
      const LaneVector x = loadVector(s.pairs.x, s.pairs.y, s.pairs.z, p);
      const LaneVector d = difference(gather(s.guess, s.pairs.slot + p), guess);
      const Lane r = load(s.pairs.distance + p), square = r * r;
      const Lane compression = s.dense ? load(s.spring + p) : all(1.0f);
      const Lane inverse = 1.0f / (greatest(square, shortest) * compression);  // one division for two
      const Lane inverse_square = inverse * compression;
      const Lane along = dot(x, d);
      const LaneVector e = difference(x, d);
      const Lane length = root(dot(e, e));
      if (s.dense) {
        guessed += kernel.value(length);
        lag += compression * along;
      }
      if (s.sprung) {
        if (!alike) {
          for (int k = 0; k < lane_width; ++k) {
            const std::uint8_t with = s.material[s.pairs.slot[p + k] / slot_size];
            damping[k] = dashpots[with];
            stiffness[k] = rules != nullptr ? rules[with].stiffness : 0.0f;
          }
        }
        const Lane both = 0.5f * (own + gatherNumbers(s.amend, s.pairs.slot + p));
        const Lane dashpot = damping * dashpotWeight(per_square, square) * both;
        // The length at u = 0, were it as linear there as it is near the guess.
        const Lane start = length + along * r * inverse_square;
        Lane spring = dashpot, push = dashpot * (r - start);
        if (rules != nullptr) {
          const Lane kept = load(s.rest_length + p);
          // What flowed after the last step flows on in this one: its elongation shrinks again, and it is as
          // much less stiff (the secant of its force), so that it stores no more at u = 0 than it did.
          const Lane secant = 0.5f * (own_secant + gatherNumbers(s.secant, s.pairs.slot + p));
          const Lane bond = (kept > 0.0f ? secant * stiffness : Lane{}) * inverse_square;
          spring += bond, push += bond * (kept - start);
        }
        const Lane per_compression = greatest(square, shortest) * inverse;
        store(s.spring + p, spring * per_compression * per_compression);
        push *= r;
        add(forces, times(push, x));
      }
    }
    storeSlot(s.force + slot_size * i, sums(forces));
    s.excess[i] = (sum(guessed) + kernel.sigma) / s.lattice_sum - 1.0f - sum(lag);
  }
}
TACTILE_CLAY_MULTIVERSION
void lineariseAlike(const Setup s, std::size_t first, std::size_t last) {
  linearise<true>(s, first, last);
}
TACTILE_CLAY_MULTIVERSION
void lineariseMixed(const Setup s, std::size_t first, std::size_t last) {
  linearise<false>(s, first, last);
}

/// Sum over the initial lattice of the dashpot weight times r^4.
double latticeDashpots(const Kernel& kernel, float spacing) {
  double total = 0.0;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const double square = static_cast<double>(spacing) * spacing * (x * x + y * y + z * z);
        total += std::pow(1.0 - square / (static_cast<double>(kernel.h) * kernel.h), 3.0) * square * square;
      }
    }
  }
  return total;
}

}  // namespace

Potential::Potential(const Kernel& kernel, float spacing, const std::vector<Material>& materials)
    : kernel_(kernel),
      volume_(spacing * spacing * spacing),
      lattice_sum_(latticeSum(kernel, spacing)),
      lattice_dashpots_(static_cast<float>(latticeDashpots(kernel, spacing))),
      materials_(materials.size()) {
  for (const Material& a : materials) {
    bulk_.push_back(static_cast<float>(a.bulk_modulus) * volume_);
    flow_index_.push_back(static_cast<float>(a.flow_index));
    thins_ = thins_ || (a.flow_index < 1.0 && a.viscosity > 0.0);
    dense_ = dense_ || a.bulk_modulus > 0.0;
    for (const Material& b : materials) {
      // Between two materials: two layers in shear, whose compliances add up.
      const double both = a.viscosity + b.viscosity;
      const double eta = both > 0.0 ? 2.0 * a.viscosity * b.viscosity / both : 0.0;
      // Springs along pairs have the shear modulus sum_j k r^2 / (30 V), averaged over directions.
      dashpot_.push_back(static_cast<float>(30.0 * volume_ * eta / lattice_dashpots_));
      sprung_ = sprung_ || eta > 0.0;
    }
  }
}

void Potential::begin(const Neighbourhood& near, const Particles& particles, const Bonds* bonds,
                      const VectorField& guess, float dt) {
  near_ = &near;
  particles_ = &particles;
  sprung_ = sprung_ || bonds != nullptr;
  const std::size_t n = particles.size();
  if (dense_)
    for (auto* numbers : {&x_, &y_, &z_}) numbers->resize(near.pairs());
  if (dense_ || sprung_) spring_.resize(near.pairs());
  dashpot_of_step_.clear();
  for (const float dashpot : dashpot_) dashpot_of_step_.push_back(dashpot / dt);
  force_.resize(n), squeezed_.resize(n);
  for (auto* numbers : {&excess_, &beyond_, &ratio_, &active_, &pressure_, &amend_, &steepness_, &growth_,
                        &compression_, &lent_, &pressure_change_})
    numbers->resize(n);
  const Setup setup{
      {near.begins(), near.paddeds(), near.slots(), near.x(), near.y(), near.z(), near.distances()},
      kernel_,
      lattice_sum_,
      lattice_dashpots_,
      guess.data(),
      particles.material.data(),
      materials_,
      dashpot_of_step_.data(),
      bonds,
      bonds != nullptr ? bonds->restLengths().data() : nullptr,
      bonds != nullptr ? bonds->flow().secant.data() : nullptr,
      dense_,
      sprung_,
      x_.data(),
      y_.data(),
      z_.data(),
      spring_.data(),
      ratio_.data(),
      amend_.data(),
      steepness_.data(),
      force_.data(),
      excess_.data()};
  parallelRanges(n, range_size, [&](std::size_t first, std::size_t last) {
    measureSurroundings(setup, first, last);
    if (thins_) thinDashpots(setup, flow_index_.data(), dt, first, last);
  });
  parallelRanges(n, range_size, [&](std::size_t first, std::size_t last) {
    if (materials_ == 1)
      lineariseAlike(setup, first, last);
    else
      lineariseMixed(setup, first, last);
  });
}

PairArrays Potential::pairs() const {
  const bool many = particles_->size() > few;
  if (!dense_)
    return {near_->begins(), near_->paddeds(), near_->slots(), near_->x(),
            near_->y(),      near_->z(),       spring_.data(), many};
  return {near_->begins(), near_->paddeds(), near_->slots(), x_.data(),
          y_.data(),       z_.data(),        spring_.data(), many};
}

/// Some is compressed beyond by rounding and by what is linear; that may push. What a particle is lent for it
/// in a step is no more than its energy at `recovery_speed`, and what it may keep of that for the next is no
/// more than at `forgiven_speed`: what stays squeezed by others would be lent it again and again.
bool Potential::limitExcess(std::size_t first, std::size_t last) {
  if (!dense_) return false;
  bool any = false;
  for (std::size_t i = first; i < last; ++i) {
    beyond_[i] = lent_[i] = 0.0f;
    const float stiff = stiffness(i);
    if (!(stiff > 0.0f)) continue;
    const float paid = particles_->compression[i];
    const float paid_square = bulk_[particles_->material[i]] / stiff * paid * paid;
    const float per_square_speed = 1.0f / (stiff * particles_->inverse_mass[i]);
    const float bounded =
        std::min(excess_[i], std::sqrt(paid_square + per_square_speed * recovery_speed * recovery_speed));
    const float kept = std::sqrt(paid_square + per_square_speed * forgiven_speed * forgiven_speed);
    beyond_[i] = excess_[i] - bounded;
    excess_[i] = bounded;
    lent_[i] = bounded > kept ? bounded * bounded - kept * kept : 0.0f;
    any = any || beyond_[i] > 0.0f;
  }
  return any;
}

/// Along its gradient, C_i alone is undone by displacements of all neighbours together of C_i over the
/// gradient's length.
void Potential::recovery(float dt, VectorField& w) {
  const std::size_t n = particles_->size();
  const float farthest = std::min(recovery_speed * dt, 0.25f * kernel_.h);  // gradients are of the start
  parallelRanges(n, range_size, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      w[i].setZero();
      const float undone = std::min(beyond_[i], farthest * steepness_[i]);
      pressure_[i] = undone > 0.0f ? recovery_share * undone / (steepness_[i] * steepness_[i]) : 0.0f;
    }
  });
  parallelRanges(n, range_size, [&](std::size_t first, std::size_t last) {
    findPressed(pairs(), {pressure_.data(), w.data()}, first, last, squeezed_.data());
    // Of many that are squeezed into one place, as in a closing fist, it would add up to a leap.
    for (std::size_t i = first; i < last; ++i)
      if (w[i].norm() > 2.0f * farthest) w[i] *= 2.0f * farthest / w[i].norm();
  });
}

void Potential::stretch(const VectorField& u, VectorField& f, std::vector<float>& growth, std::size_t first,
                        std::size_t last) {
  const Stretch one{u.data(), f.data(), growth.data()};
  if (sprung_ && dense_)
    stretchBoth(pairs(), one, first, last);
  else if (sprung_)
    stretchSprings(pairs(), one, first, last);
  else if (dense_)
    stretchDensity(pairs(), one, first, last);
  else
    for (std::size_t i = first; i < last; ++i) f[i].setZero();
}

/// Adds what is at u = 0 to the forces of the springs and, where there is density, to the growth of C.
bool Potential::addStart(VectorField& f, std::size_t first, std::size_t last) {
  bool pressing = false;
  for (std::size_t i = first; i < last; ++i) {
    f[i] += force_[i];
    if (!dense_) continue;
    const float c = compression_[i] += excess_[i];
    active_[i] = c > 0.0f ? stiffness(i) : 0.0f;
    pressure_[i] = active_[i] * c;
    pressing = pressing || c > 0.0f;
  }
  return pressing;
}

bool Potential::startForce(const VectorField& u, VectorField& f, std::size_t first, std::size_t last) {
  stretch(u, f, compression_, first, last);
  return addStart(f, first, last);
}

bool Potential::startForceAndChange(const VectorField& u, VectorField& f, const VectorField& p,
                                    VectorField& change, std::size_t first, std::size_t last) {
  if (sprung_ && dense_) {
    stretchBothTwice(pairs(), {u.data(), f.data(), compression_.data()},
                     {p.data(), change.data(), growth_.data()}, first, last);
  } else {
    stretch(u, f, compression_, first, last);
    stretch(p, change, growth_, first, last);
  }
  const bool pressing = addStart(f, first, last);
  if (dense_)
    for (std::size_t i = first; i < last; ++i) pressure_change_[i] = active_[i] * growth_[i];
  return pressing;
}

void Potential::startChange(const VectorField& p, VectorField& f, std::size_t first, std::size_t last) {
  stretch(p, f, growth_, first, last);
  if (!pressing_) return;
  for (std::size_t i = first; i < last; ++i) pressure_[i] = active_[i] * growth_[i];
}

void Potential::follow(float step, std::size_t first, std::size_t last) {
  if (!dense_) return;
  for (std::size_t i = first; i < last; ++i) compression_[i] += step * growth_[i];
}

void Potential::finishForce(VectorField& f, std::size_t first, std::size_t last) {
  if (pressing_) findPressed(pairs(), {pressure_.data(), f.data()}, first, last, squeezed_.data());
}

void Potential::finishForceAndChange(VectorField& f, VectorField& change, std::size_t first,
                                     std::size_t last) {
  if (!pressing_) return;
  findPressedTwice(pairs(), {pressure_.data(), f.data()}, {pressure_change_.data(), change.data()}, first,
                   last, squeezed_.data());
}

void Potential::finishChange(VectorField& f, std::size_t first, std::size_t last) const {
  if (pressing_) pressPairs(pairs(), {pressure_.data(), f.data()}, first, last, squeezed_.data());
}

void Potential::force(const VectorField& u, VectorField& f) {
  std::atomic<bool> pressing{false};
  parallelRanges(f.size(), range_size, [&](std::size_t first, std::size_t last) {
    if (startForce(u, f, first, last)) pressing = true;
  });
  setPressing(pressing);
  parallelRanges(f.size(), range_size,
                 [&](std::size_t first, std::size_t last) { finishForce(f, first, last); });
}

void Potential::change(const VectorField& p, VectorField& f) {
  parallelRanges(f.size(), range_size,
                 [&](std::size_t first, std::size_t last) { startChange(p, f, first, last); });
  parallelRanges(f.size(), range_size,
                 [&](std::size_t first, std::size_t last) { finishChange(f, first, last); });
}

}  // namespace tactile_clay::clay
