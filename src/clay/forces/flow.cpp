#include "clay/forces/flow.h"

#include <algorithm>
#include <cmath>

#include "clay/forces/bonds.h"
#include "lanes/lane_matrix.h"
#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

// Sum of the squares of the rest lengths of a particle in the initial lattice, spacings^2.
constexpr float fresh = 6.0f * 1.0f + 12.0f * 2.0f;
// Minimum of the same sum, that of a flat face: an edge or a crumb is stiffened no more than a face.
constexpr float minimum = 5.0f * 1.0f + 8.0f * 2.0f;

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
  float *share, *secant, *dilation;
};

/// Sums over the bonds of a particle.
struct Strained {
  Symmetric stress;  // J, twice the stress times volume
  Symmetric fabric;  // J, the same if every bond had a strain of one
  LaneVector pull;   // N, of the bonds on the particle
};

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

/// Mean strain v of the bonds, without the part that a change of shape adds if more bonds point in one
/// direction than in another. It is part of the strain tensor v + E for which the bonds have their stress T:
/// sum k (l n)(v + n E n)(l n)^T = T. With the fourth moments of an isotropic fabric: T = v N + 2 Q E / 15,
/// tr T = Q v + E : N, Q = tr N. Otherwise clay that goes on flowing would keep that part: 8 % in a shear of
/// 1.2.
TACTILE_CLAY_INLINE Lane volumeStrain(const Strained& total) {
  const Symmetric &t = total.stress, &n = total.fabric;
  const Lane square = trace(n), per_square = square > 0.0f ? 1.0f / square : Lane{};
  const Lane scale = 7.5f * per_square * per_square;
  const Symmetric uneven = deviator(n);
  const Lane mean = trace(t) * per_square - scale * product(t, uneven);
  // The denominator is bounded for particles with few bonds.
  return mean / max(1.0f - scale * product(uneven, uneven), all(0.5f));
}

template <bool alike>
TACTILE_CLAY_INLINE Strained strainedBonds(const Measure& m, std::size_t i) {
  const BondRule* const rules = m.rules + m.material[i] * m.materials;
  const Lane own_stiffness = all(m.stiffness[i]), own_before = all(m.before[i]);
  Lane rule = all(rules[0].stiffness);
  Strained total{};
  for (std::uint32_t p = m.pairs.begin[i]; p < m.pairs.end[i]; p += lane_width) {
    const std::uint32_t* slots = m.pairs.slot + p;
    const Lane rest_length = load(m.rest_length + p);
    const LaneOrder bonded = rest_length > 0.0f;  // particles at the same place are not
    if (!alike) {
      float of[lane_width];
      for (int k = 0; k < lane_width; ++k) of[k] = rules[m.material[slots[k] / slot_size]].stiffness;
      rule = load(of);
    }
    const Lane after = own_stiffness + gatherNumbers(m.stiffness, slots);
    const Lane before = own_before + gatherNumbers(m.before, slots);
    const Lane stiffness = bonded ? 0.5f * rule * (before < after ? before : after) : Lane{};
    const LaneVector x = loadVector(m.pairs.x, m.pairs.y, m.pairs.z, p);
    const Lane length = load(m.pairs.distance + p), strain = 1.0f - rest_length / length;
    const LaneVector pull = times(bonded ? stiffness * strain : Lane{}, x);
    addOuter(total.stress, pull, x);
    total.pull = difference(total.pull, pull);
    addOuter(total.fabric, times(stiffness, x), x);
  }
  return total;
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

template <bool alike>
TACTILE_CLAY_INLINE void measure(const Measure& m, std::size_t first, std::size_t last) {
  std::size_t contact = static_cast<std::size_t>(
      std::lower_bound(m.contacts.begin(), m.contacts.end(), first,
                       [](const Contact& c, std::size_t i) { return c.particle < i; }) -
      m.contacts.begin());
  for (std::size_t i = first; i < last; i += lane_width) {
    Totals<Strained> totals(last - i);
    Lane yield{}, kept{};
    for (int k = 0; k < lane_width && i + k < last; ++k) {
      yield[k] = m.yield[m.material[i + k]];
      kept[k] = m.kept[m.material[i + k]];
      totals.set(k, strainedBonds<alike>(m, i + k));
    }
    const Strained total = totals.get();
    Symmetric s = deviator(total.stress);
    contact = addContacts(m.contacts, contact, i, m.spacing, total.pull, s);
    const Lane size = 0.5f * root(0.5f * product(s, s));  // J, |s| V
    const Lane share = kept * (size > yield ? yield / size : all(1.0f));
    store(m.share + i, share);
    store(m.secant + i, share * load(m.stiffness + i));
    store(m.dilation + i, volumeStrain(total));
  }
}
TACTILE_CLAY_MULTIVERSION
void measureAlike(const Measure m, std::size_t first, std::size_t last) {
  measure<true>(m, first, last);
}
TACTILE_CLAY_MULTIVERSION
void measureMixed(const Measure m, std::size_t first, std::size_t last) {
  measure<false>(m, first, last);
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
  const Measure m{
      near.arrays(),      bonds.restLengths().data(), particles.material.data(), bonds.rules(0),
      bonds.materials(),  bonds.yields().data(),      flow.kept.data(),          contacts,
      bonds.spacing(),    flow.stiffness.data(),      flow.before.data(),        flow.share.data(),
      flow.secant.data(), flow.dilation.data()};
  (bonds.materials() == 1 ? measureAlike : measureMixed)(m, first, last);
}

}  // namespace tactile_clay::clay
