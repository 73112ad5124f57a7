#include "clay/forces/linearise.h"

#include <algorithm>
#include <cmath>

#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

constexpr float slowest = 0.1f;           // 1/s, shear rate below which a viscosity no longer grows
constexpr float fewest_dashpots = 0.25f;  // of the lattice's; with fewer a crumb is not stiffened further

// Makes the initial lattice isotropic: sum w x^4 = 3 sum w x^2 y^2 over its neighbours at q^2 = 1/4, 1/2 and
// 3/4 is w(1/4) = 2 w(1/2) + 8 w(3/4).
constexpr float steeper = 28.0f / 31.0f;

/// Stiffness of a dashpot over x x^T, by distance: w = (1 - q^2)^2 (1 - 28/31 q^2), q = r / h. With the usual
/// -W'/r^3 the lattice is far from isotropic, with (1 - q^2)^3 within 5 %.
/// @param per_square 1 / h^2
TACTILE_CLAY_INLINE Lane dashpotWeight(float per_square, const Lane& square) {
  const Lane q_square = square * per_square, a = positive(1.0f - q_square);
  return a * a * (1.0f - steeper * q_square);
}

/// For particles [first, last): rho / rho_0, and the factor by which dashpots are stronger because a surface
/// takes others away. For their pairs: the gradients g, and, in the place of the later springs, g over x.
TACTILE_CLAY_MULTIVERSION
void measureDensities(const Setup s, std::size_t first, std::size_t last) {
  // The compiler may not move these divisions out of the loop.
  const float per_lattice_sum = 1.0f / s.lattice_sum, per_square = 1.0f / (s.kernel.h * s.kernel.h);
  const Lane shortest = all(1e-4f * s.kernel.h);
  // Keeps gradients above zero, since springs are stored per square of a gradient; too small to change C.
  const Lane min_compression = all(1e-8f * per_square);
  for (std::size_t i = first; i < last; ++i) {
    Lane density{}, dashpots{}, steepness{};
    for (std::uint32_t p = s.pairs.begin[i]; p < s.pairs.end[i]; p += lane_width) {
      const Lane r = load(s.pairs.distance + p), square = r * r;
      density += s.kernel.value(r);
      if (s.viscous.any) dashpots += dashpotWeight(per_square, square) * square * square;
      if (!s.dense) continue;
      const Lane compression = max(-s.kernel.slope(r) * per_lattice_sum / max(r, shortest), min_compression);
      const LaneVector g = times(compression, loadVector(s.pairs.x, s.pairs.y, s.pairs.z, p));
      store(s.of_pairs.x + p, g.x);
      store(s.of_pairs.y + p, g.y);
      store(s.of_pairs.z + p, g.z);
      store(s.of_pairs.spring + p, compression);
      steepness += dot(g, g);
    }
    s.steepness[i] = std::sqrt(sum(steepness));
    s.ratio[i] = (sum(density) + s.kernel.sigma) * per_lattice_sum;
    // A particle at a surface has fewer pairs, but no less clay.
    s.amend[i] = 1.0f / std::max(sum(dashpots) / s.viscous.lattice, fewest_dashpots);
  }
}

/// Thins the viscosity of particles [first, last) with the shear rate: Herschel & Bulkley's eta rate^(n - 1).
/// The rate is the one at which a Newtonian fluid would dissipate as much as the dashpots do at the guess.
/// For an isotropic fluid sum_j w (x.v)^2 = rate^2 sum_j w r^4 / 15.
TACTILE_CLAY_MULTIVERSION
void thinDashpots(const Setup s, std::size_t first, std::size_t last) {
  const float per_square = 1.0f / (s.kernel.h * s.kernel.h);
  for (std::size_t i = first; i < last; ++i) {
    const float n = s.viscous.flow_index[s.material[i]];
    if (n == 1.0f) continue;
    const LaneVector guess = allOf(s.guess + slot_size * i);
    Lane squares{};
    for (std::uint32_t p = s.pairs.begin[i]; p < s.pairs.end[i]; p += lane_width) {
      const LaneVector x = loadVector(s.pairs.x, s.pairs.y, s.pairs.z, p);
      const Lane r = load(s.pairs.distance + p);
      const Lane along = dot(x, difference(gather(s.guess, s.pairs.slot + p), guess));
      squares += dashpotWeight(per_square, r * r) * along * along;
    }
    const float rate = std::sqrt(15.0f * s.amend[i] * sum(squares) / s.viscous.lattice) / s.viscous.dt;
    s.amend[i] *= std::pow(std::max(rate, slowest), n - 1.0f);
  }
}

/// Factor of the dashpots of the pairs from p on: the mean of their ends. `own` is that of one end.
TACTILE_CLAY_INLINE Lane amendment(const Setup& s, const Lane& own, std::uint32_t p) {
  return 0.5f * (own + gatherNumbers(s.amend, s.pairs.slot + p));
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
    const float* dashpots = s.viscous.dashpot + s.material[i] * s.materials;
    const BondRule* rules = s.elastic.bonds != nullptr ? s.elastic.bonds->rules(s.material[i]) : nullptr;
    Lane damping = all(dashpots[0]), stiffness = all(rules != nullptr ? rules->stiffness : 0.0f);
    const Lane own_secant = all(rules != nullptr ? s.elastic.secant[i] : 0.0f);
    LaneVector forces{};
    Lane guessed{}, lag{};
    for (std::uint32_t p = s.pairs.begin[i]; p < s.pairs.end[i]; p += lane_width) {
      const LaneVector x = loadVector(s.pairs.x, s.pairs.y, s.pairs.z, p);
      const LaneVector d = difference(gather(s.guess, s.pairs.slot + p), guess);
      const Lane r = load(s.pairs.distance + p), square = r * r;
      const Lane compression = s.dense ? load(s.of_pairs.spring + p) : all(1.0f);
      const Lane inverse = 1.0f / (max(square, shortest) * compression);  // one division for two
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
        // The length at u = 0, if it is extrapolated linearly from the guess.
        const Lane start = length + along * r * inverse_square;
        const Lane dashpot =
            s.viscous.any ? damping * dashpotWeight(per_square, square) * amendment(s, own, p) : Lane{};
        Lane spring = dashpot, push = dashpot * (r - start);
        if (rules != nullptr) {
          const Lane kept = load(s.elastic.rest_length + p);
          // A bond that flowed after the last step goes on flowing in this one: its elongation shrinks again.
          // Its stiffness is smaller by the same factor (the secant of its force), so that at u = 0 it stores
          // no more than before.
          const Lane secant = 0.5f * (own_secant + gatherNumbers(s.elastic.secant, s.pairs.slot + p));
          const Lane bond = (kept > 0.0f ? secant * stiffness : Lane{}) * inverse_square;
          spring += bond;
          push += bond * (kept - start);
        }
        const Lane per_compression = max(square, shortest) * inverse;
        store(s.of_pairs.spring + p, spring * per_compression * per_compression);
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

/// A spring is stored per square of its gradient g, and lengths are linear about the guess, as in
/// `linearise`.
template <bool alike>
TACTILE_CLAY_INLINE void change(const Setup s, std::size_t first, std::size_t last) {
  const Lane shortest = all(1e-8f * s.kernel.h * s.kernel.h);
  for (std::size_t i = first; i < last; ++i) {
    const LaneVector guess = allOf(s.guess + slot_size * i);
    const BondRule* const rules = s.elastic.bonds->rules(s.material[i]);
    const Lane own = all(s.elastic.change[i]);
    Lane stiffness = all(rules[0].stiffness);
    LaneVector forces{};
    bool changed = false;
    for (std::uint32_t p = s.pairs.begin[i]; p < s.pairs.end[i]; p += lane_width) {
      const Lane kept = load(s.elastic.rest_length + p);
      const Lane secant = 0.5f * (own + gatherNumbers(s.elastic.change, s.pairs.slot + p));
      const LaneOrder changes = (kept > 0.0f) & (secant != 0.0f);
      if (bits(changes) == 0) continue;
      changed = true;
      if (!alike)
        for (int k = 0; k < lane_width; ++k)
          stiffness[k] = rules[s.material[s.pairs.slot[p + k] / slot_size]].stiffness;
      const LaneVector x = loadVector(s.pairs.x, s.pairs.y, s.pairs.z, p);
      const LaneVector d = difference(gather(s.guess, s.pairs.slot + p), guess);
      const LaneVector e = difference(x, d);
      const Lane r = load(s.pairs.distance + p), square = r * r, bounded = max(square, shortest);
      const Lane bond = (changes ? secant * stiffness : Lane{}) / bounded;
      const Lane start = root(dot(e, e)) + dot(x, d) * r / bounded;
      add(forces, times(bond * (kept - start) * r, x));
      Lane per_gradient = all(1.0f);  // square of x over g
      if (s.dense) {
        const LaneVector g = loadVector(s.of_pairs.x, s.of_pairs.y, s.of_pairs.z, p);
        per_gradient = square / dot(g, g);
      }
      store(s.of_pairs.spring + p, load(s.of_pairs.spring + p) + (changes ? bond * per_gradient : Lane{}));
    }
    if (changed) storeSlot(s.force + slot_size * i, slot(s.force + slot_size * i) + sums(forces));
  }
}
TACTILE_CLAY_MULTIVERSION
void changeAlike(const Setup s, std::size_t first, std::size_t last) {
  change<true>(s, first, last);
}
TACTILE_CLAY_MULTIVERSION
void changeMixed(const Setup s, std::size_t first, std::size_t last) {
  change<false>(s, first, last);
}

}  // namespace

void measureSurroundings(const Setup& setup, std::size_t first, std::size_t last) {
  measureDensities(setup, first, last);
  if (setup.viscous.flow_index != nullptr) thinDashpots(setup, first, last);
}

void linearisePairs(const Setup& setup, std::size_t first, std::size_t last) {
  (setup.materials == 1 ? lineariseAlike : lineariseMixed)(setup, first, last);
}

void changeSecants(const Setup& setup, std::size_t first, std::size_t last) {
  (setup.materials == 1 ? changeAlike : changeMixed)(setup, first, last);
}

double latticeDashpots(const Kernel& kernel, float spacing) {
  const float per_square = 1.0f / (kernel.h * kernel.h);
  double total = 0.0;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const float square = spacing * spacing * static_cast<float>(x * x + y * y + z * z);
        total += static_cast<double>(dashpotWeight(per_square, all(square))[0] * square * square);
      }
    }
  }
  return total;
}

}  // namespace tactile_clay::clay
