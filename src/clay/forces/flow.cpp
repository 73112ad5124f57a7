#include "clay/forces/flow.h"

#include <algorithm>
#include <cmath>

#include "clay/forces/bonds.h"
#include "clay/solver/step_input.h"
#include "lanes/lane_matrix.h"
#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

// Sum of the squares of the rest lengths of a particle in the initial lattice, spacings^2.
constexpr float fresh = 6.0f * 1.0f + 12.0f * 2.0f;
// Minimum of the same sum, that of a flat face: an edge or a crumb is stiffened no more than a face.
constexpr float minimum = 5.0f * 1.0f + 8.0f * 2.0f;
// Weight of an isotropic fabric beside that of the bonds, for particles with few bonds.
constexpr float isotropic = 0.02f;

struct Measure {
  NeighbourPairs pairs;
  const float* rest_length;      // m, of each pair
  const std::uint8_t* material;  // of each particle
  const BondRule* rules;         // of each two materials
  std::size_t materials;
  const float* yield;  // J, yield stress times volume, of each material
  const float* kept;   // see Flow
  const std::vector<Contact>& contacts;
  float spacing;                    // m
  const float *stiffness, *before;  // of each particle, see Flow
  const float* u;                   // m, slots: displacements of the particles; null: none
};
struct Measured {  // of each particle, see Flow
  float *share, *secant, *dilation;
  float* change;  // of the secant
};

/// Fourth moments of the bonds of a particle, J: sum k l^2 n n n n, the stress in a direction (row) that a
/// strain in a direction (column) causes. The order is xx, yy, zz, yz, zx, xy. It is symmetric; of equal
/// components only one is stored.
struct Moments {
  Lane xxxx, yyyy, zzzz, yyzz, zzxx, xxyy, xxyz, yyyz, zzyz, xxzx, yyzx, zzzx, xxxy, yyxy, zzxy;
};
/// Sums over the bonds of a particle.
struct Strained {
  Symmetric stress;  // J, twice the stress times volume
  LaneVector pull;   // N, of the bonds on the particle
};

TACTILE_CLAY_INLINE void addFourth(Moments& to, const Lane& weight, const LaneVector& x) {
  const Lane xx = x.x * x.x, yy = x.y * x.y, zz = x.z * x.z, yz = x.y * x.z, zx = x.z * x.x, xy = x.x * x.y;
  const Lane of_xx = weight * xx, of_yy = weight * yy, of_zz = weight * zz;
  to.xxxx += of_xx * xx;
  to.yyyy += of_yy * yy;
  to.zzzz += of_zz * zz;
  to.yyzz += of_yy * zz;
  to.zzxx += of_zz * xx;
  to.xxyy += of_xx * yy;
  to.xxyz += of_xx * yz;
  to.yyyz += of_yy * yz;
  to.zzyz += of_zz * yz;
  to.xxzx += of_xx * zx;
  to.yyzx += of_yy * zx;
  to.zzzx += of_zz * zx;
  to.xxxy += of_xx * xy;
  to.yyxy += of_yy * xy;
  to.zzxy += of_zz * xy;
}

TACTILE_CLAY_INLINE Lane trace(const Symmetric& a) {
  return a.xx + a.yy + a.zz;
}
TACTILE_CLAY_INLINE Symmetric deviator(const Symmetric& a) {
  const Lane mean = trace(a) / 3.0f;
  return {a.xx - mean, a.yy - mean, a.zz - mean, a.yz, a.zx, a.xy};
}
TACTILE_CLAY_INLINE Lane product(const Symmetric& a, const Symmetric& b) {
  return a.xx * b.xx + a.yy * b.yy + a.zz * b.zz + 2.0f * (a.yz * b.yz + a.zx * b.zx + a.xy * b.xy);
}

/// Mean strain v of bonds with stress T, for an isotropic fabric beside N = sum k l^2 n n. It is part of the
/// strain tensor v + E for which the bonds have their stress: sum k (l n)(v + n E n)(l n)^T = T. With the
/// fourth moments of an isotropic fabric: T = v N + 2 Q E / 15, tr T = Q v + E : N, Q = tr N.
TACTILE_CLAY_INLINE Lane nearlyIsotropicVolumeStrain(const Symmetric& t, const Symmetric& n) {
  const Lane square = trace(n), per_square = square > 0.0f ? 1.0f / square : Lane{};
  const Lane scale = 7.5f * per_square * per_square;
  const Symmetric uneven = deviator(n);
  const Lane mean = trace(t) * per_square - scale * product(t, uneven);
  // The denominator is bounded for particles with few bonds.
  return mean / max(1.0f - scale * product(uneven, uneven), all(0.5f));
}

/// A third of the strain of the volume that the bonds measure: of the strain tensor S that fits their strains
/// best, the minimum of sum k l^2 (strain - n S n)^2. So M S = T, with the fourth moments M. An isotropic
/// fabric with its own solution is added to it with a small weight: with fewer than six bonds M is singular.
/// The plain mean strain of the bonds, or fourth moments of an isotropic fabric, would let clay that goes on
/// flowing have another volume: bonds turn into the direction of the flow.
TACTILE_CLAY_INLINE Lane volumeStrain(const Symmetric& t, const Moments& m) {
  const Symmetric n{m.xxxx + m.xxyy + m.zzxx, m.xxyy + m.yyyy + m.yyzz, m.zzxx + m.yyzz + m.zzzz,
                    m.xxyz + m.yyyz + m.zzyz, m.xxzx + m.yyzx + m.zzzx, m.xxxy + m.yyxy + m.zzxy};
  const Lane v = nearlyIsotropicVolumeStrain(t, n), mean = v * trace(n) / 3.0f;
  const Symmetric e = deviator(sum(t, times(-v, n)));
  const Lane w = isotropic / 15.0f * trace(n);
  Lane lower[6][6] = {{m.xxxx + 3.0f * w},
                      {m.xxyy + w, m.yyyy + 3.0f * w},
                      {m.zzxx + w, m.yyzz + w, m.zzzz + 3.0f * w},
                      {m.xxyz, m.yyyz, m.zzyz, m.yyzz + w},
                      {m.xxzx, m.yyzx, m.zzzx, m.zzxy, m.zzxx + w},
                      {m.xxxy, m.yyxy, m.zzxy, m.yyzx, m.xxyz, m.xxyy + w}};
  const Lane right[6] = {t.xx + isotropic * (e.xx + mean), t.yy + isotropic * (e.yy + mean),
                         t.zz + isotropic * (e.zz + mean), t.yz + isotropic * e.yz,
                         t.zx + isotropic * e.zx,          t.xy + isotropic * e.xy};
  Lane strain[6];
  solveSymmetric(lower, right, strain);
  return (strain[0] + strain[1] + strain[2]) / 3.0f;
}

/// Adds the bonds of particle i to `total`, eight pairs at a time: add(total, stiffness, rest_length, p),
/// with the stiffness (N/m, 0: not bonded) and the rest length (m) of the pairs from p on. `moved`: rest
/// lengths have already followed the last change of the stiffness.
template <bool alike, bool moved, typename Total, typename Add>
TACTILE_CLAY_INLINE Total sumOverBonds(const Measure& m, std::size_t i, const Add& add) {
  const BondRule* const rules = m.rules + m.material[i] * m.materials;
  const Lane own_stiffness = all(m.stiffness[i]), own_before = all(m.before[i]);
  Lane rule = all(rules[0].stiffness);
  Total total{};
  for (std::uint32_t p = m.pairs.begin[i]; p < m.pairs.end[i]; p += lane_width) {
    const std::uint32_t* slots = m.pairs.slot + p;
    const Lane rest_length = load(m.rest_length + p);
    if (!alike) {
      float of[lane_width];
      for (int k = 0; k < lane_width; ++k) of[k] = rules[m.material[slots[k] / slot_size]].stiffness;
      rule = load(of);
    }
    const Lane after = own_stiffness + gatherNumbers(m.stiffness, slots);
    Lane softer = after;
    if (!moved) {
      const Lane before = own_before + gatherNumbers(m.before, slots);
      softer = before < after ? before : after;
    }
    const LaneOrder bonded = rest_length > 0.0f;  // particles at the same place are not
    add(total, bonded ? 0.5f * rule * softer : Lane{}, rest_length, p);
  }
  return total;
}

/// @param moved whether the displacements u move the particles
template <bool alike, bool moved>
TACTILE_CLAY_INLINE Strained strainedBonds(const Measure& m, std::size_t i) {
  LaneVector own{};
  if (moved) own = allOf(m.u + slot_size * i);
  const Lane shortest = all(1e-6f * m.spacing);
  const auto add = [&](Strained& total, const Lane& stiffness, const Lane& rest_length, std::uint32_t p) {
    LaneVector x = loadVector(m.pairs.x, m.pairs.y, m.pairs.z, p);
    Lane length = load(m.pairs.distance + p);
    if (moved) {
      x = difference(x, difference(gather(m.u, m.pairs.slot + p), own));
      length = max(root(dot(x, x)), shortest);
    }
    const Lane strain = 1.0f - rest_length / length;
    const LaneVector pull = times(stiffness > 0.0f ? stiffness * strain : Lane{}, x);
    addOuter(total.stress, pull, x);
    total.pull = difference(total.pull, pull);
  };
  return sumOverBonds<alike, moved, Strained>(m, i, add);
}

template <bool alike>
TACTILE_CLAY_INLINE Moments momentsOfBonds(const Measure& m, std::size_t i) {
  const auto add = [&](Moments& total, const Lane& stiffness, const Lane&, std::uint32_t p) {
    const Lane length = load(m.pairs.distance + p);
    addFourth(total, stiffness > 0.0f ? stiffness / (length * length) : Lane{},
              loadVector(m.pairs.x, m.pairs.y, m.pairs.z, p));
  };
  return sumOverBonds<alike, false, Moments>(m, i, add);
}

/// A third of the strain of the volume of the eight particles from i on; 0 of those that do not flow.
/// @param flows bits of those that do
template <bool alike>
TACTILE_CLAY_INLINE Lane flowingVolumeStrain(const Measure& m, std::size_t i, unsigned flows,
                                             const Symmetric& stress) {
  if (flows == 0) return Lane{};
  Totals<Moments> moments(0);
  for (int k = 0; k < lane_width; ++k)
    if ((flows >> k & 1u) != 0) moments.set(k, momentsOfBonds<alike>(m, i + k));
  return volumeStrain(stress, moments.get());
}

/// Adds the forces with which colliders resist the pull of bonds, to the stress of the eight particles from
/// `first` on. They are at most the friction there.
/// @param contact index of the first contact that may belong to these particles
/// @return index of the first contact after them
std::size_t addContacts(const std::vector<Contact>& contacts, std::size_t contact, std::size_t first,
                        float spacing, const LaneVector& pull, Symmetric& stress) {
  for (; contact < contacts.size() && contacts[contact].particle < first + lane_width; ++contact) {
    const Contact& c = contacts[contact];
    const std::size_t k = c.particle - first;
    const Eigen::Vector3f& n = c.normal;
    const Eigen::Vector3f pulled(pull.x[k], pull.y[k], pull.z[k]), along = pulled - pulled.dot(n) * n;
    const float maximum = c.friction.norm(), size = along.norm();
    const Eigen::Vector3f f = spacing * (size > maximum ? maximum / size : 1.0f) * along;
    stress.xx[k] += 2.0f * f.x() * n.x();
    stress.yz[k] += f.y() * n.z() + f.z() * n.y();
    stress.yy[k] += 2.0f * f.y() * n.y();
    stress.zx[k] += f.z() * n.x() + f.x() * n.z();
    stress.zz[k] += 2.0f * f.z() * n.z();
    stress.xy[k] += f.x() * n.y() + f.y() * n.x();
  }
  return contact;
}

template <bool alike, bool moved>
TACTILE_CLAY_INLINE void measure(const Measure& m, const Measured& to, std::size_t first, std::size_t last) {
  std::size_t contact = static_cast<std::size_t>(
      std::lower_bound(m.contacts.begin(), m.contacts.end(), first,
                       [](const Contact& c, std::size_t i) { return c.particle < i; }) -
      m.contacts.begin());
  for (std::size_t i = first; i < last; i += lane_width) {
    Totals<Strained> totals(last - i);
    Lane yield{}, kept = all(1.0f);  // lanes past the last particle do not flow
    for (int k = 0; k < lane_width && i + k < last; ++k) {
      yield[k] = m.yield[m.material[i + k]];
      kept[k] = m.kept[m.material[i + k]];
      totals.set(k, strainedBonds<alike, moved>(m, i + k));
    }
    const Strained total = totals.get();
    Symmetric s = deviator(total.stress);
    contact = addContacts(m.contacts, contact, i, m.spacing, total.pull, s);
    const Lane size = 0.5f * root(0.5f * product(s, s));  // J, |s| V
    const Lane share = kept * (size > yield ? yield / size : all(1.0f));
    const Lane secant = share * load(m.stiffness + i);
    if (moved) {
      store(to.change + i, secant - load(to.secant + i));
    } else {
      store(to.share + i, share);
      store(to.dilation + i, flowingVolumeStrain<alike>(m, i, bits(share < 1.0f), total.stress));
    }
    store(to.secant + i, secant);
  }
}
TACTILE_CLAY_MULTIVERSION
void measureAlike(const Measure m, const Measured to, std::size_t first, std::size_t last) {
  measure<true, false>(m, to, first, last);
}
TACTILE_CLAY_MULTIVERSION
void measureMixed(const Measure m, const Measured to, std::size_t first, std::size_t last) {
  measure<false, false>(m, to, first, last);
}
TACTILE_CLAY_MULTIVERSION
void measureMovedAlike(const Measure m, const Measured to, std::size_t first, std::size_t last) {
  measure<true, true>(m, to, first, last);
}
TACTILE_CLAY_MULTIVERSION
void measureMovedMixed(const Measure m, const Measured to, std::size_t first, std::size_t last) {
  measure<false, true>(m, to, first, last);
}

Measure measureOf(const Neighbourhood& near, const Particles& particles, const Bonds& bonds, const Flow& flow,
                  const std::vector<Contact>& contacts) {
  return {near.arrays(),     bonds.restLengths().data(), particles.material.data(), bonds.rules(0),
          bonds.materials(), bonds.yields().data(),      flow.kept.data(),          contacts,
          bonds.spacing(),   flow.stiffness.data(),      flow.before.data(),        nullptr};
}

}  // namespace

void Flow::resize(std::size_t particles) {
  const std::size_t whole_lanes = (particles + lane_width - 1) / lane_width * lane_width;
  for (auto* numbers : {&share, &stiffness, &before, &secant, &dilation}) numbers->resize(whole_lanes);
}

float bondStiffness(float squares) {
  const float ratio = std::max(squares, minimum) / fresh;
  return 1.0f / (ratio < 1.0f ? std::sqrt(ratio) : ratio);
}

void measureFlow(const Neighbourhood& near, const Particles& particles, const Bonds& bonds,
                 const std::vector<Contact>& contacts, std::size_t first, std::size_t last, Flow& flow) {
  const Measured to{flow.share.data(), flow.secant.data(), flow.dilation.data(), nullptr};
  (bonds.materials() == 1 ? measureAlike : measureMixed)(measureOf(near, particles, bonds, flow, contacts),
                                                         to, first, last);
}

void measureSecants(const StepInput& input, const std::vector<Contact>& contacts, const VectorField& u,
                    std::size_t first, std::size_t last, Secants& secants) {
  const Bonds& bonds = *input.bonds;
  Measure m = measureOf(input.near, input.particles, bonds, bonds.flow(), contacts);
  m.u = u.data();
  const Measured to{nullptr, secants.value.data(), nullptr, secants.change.data()};
  (bonds.materials() == 1 ? measureMovedAlike : measureMovedMixed)(m, to, first, last);
}

}  // namespace tactile_clay::clay
