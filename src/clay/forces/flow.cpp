#include "clay/forces/flow.h"

#include <algorithm>
#include <cmath>

#include "clay/forces/bonds.h"
#include "clay/forces/fabric.h"
#include "clay/solver/step_input.h"
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
  const float* u;                   // m, slots: displacements of the particles; null: none
};
struct Measured {  // of each particle, see Flow
  float *share, *secant;
  float *normal, *shear;  // slots
  float* change;          // of the secant
};

/// Sums over the bonds of a particle.
struct Strained {
  Symmetric stress;  // J, twice the stress times volume
  LaneVector pull;   // N, of the bonds on the particle
};

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

/// `volumeStrain` of the eight particles from i on; 0 of those that do not flow.
/// @param flows bits of those that do
template <bool alike>
TACTILE_CLAY_INLINE Symmetric flowingVolumeStrain(const Measure& m, std::size_t i, unsigned flows,
                                                  const Symmetric& stress) {
  if (flows == 0) return Symmetric{};
  Totals<Moments> moments(0);
  for (int k = 0; k < lane_width; ++k)
    if ((flows >> k & 1u) != 0) moments.set(k, momentsOfBonds<alike>(m, i + k));
  return volumeStrain(stress, moments.get());
}

/// Adds the forces with which colliders resist the pull of bonds, to the stress of the eight particles from
/// `first` on. Along the surface they are at most the friction there. Along the normal they only press.
/// @param contact index of the first contact that may belong to these particles
/// @return index of the first contact after them
std::size_t addContacts(const std::vector<Contact>& contacts, std::size_t contact, std::size_t first,
                        float spacing, const LaneVector& pull, Symmetric& stress) {
  for (; contact < contacts.size() && contacts[contact].particle < first + lane_width; ++contact) {
    const Contact& c = contacts[contact];
    const std::size_t k = c.particle - first;
    const Eigen::Vector3f& n = c.normal;
    const Eigen::Vector3f pulled(pull.x[k], pull.y[k], pull.z[k]), along = c.along(pulled);
    const float maximum = c.friction.norm(), size = along.norm();
    const float pressing = c.state == Contact::State::open ? 0.0f : std::min(pulled.dot(n), 0.0f);
    const Eigen::Vector3f f =
        spacing * ((size > maximum ? maximum / size : 1.0f) * along + 0.5f * pressing * n);
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
    Symmetric stress = total.stress;
    contact = addContacts(m.contacts, contact, i, m.spacing, total.pull, stress);
    const Symmetric s = deviator(stress);
    const Lane size = 0.5f * root(0.5f * product(s, s));  // J, |s| V
    const Lane share = kept * (size > yield ? yield / size : all(1.0f));
    const Lane secant = share * load(m.stiffness + i);
    if (moved) {
      store(to.change + i, secant - load(to.secant + i));
    } else {
      store(to.share + i, share);
      const Symmetric kept_strain = flowingVolumeStrain<alike>(m, i, bits(share < 1.0f), total.stress);
      scatter({kept_strain.xx, kept_strain.yy, kept_strain.zz}, to.normal + slot_size * i, slot_size);
      scatter({kept_strain.yz, kept_strain.zx, kept_strain.xy}, to.shear + slot_size * i, slot_size);
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
  for (auto* numbers : {&share, &stiffness, &before, &secant}) numbers->resize(whole_lanes);
  volume.normal.resize(whole_lanes);
  volume.shear.resize(whole_lanes);
}

float bondStiffness(float squares) {
  const float ratio = std::max(squares, minimum) / fresh;
  return 1.0f / (ratio < 1.0f ? std::sqrt(ratio) : ratio);
}

void measureFlow(const Neighbourhood& near, const Particles& particles, const Bonds& bonds,
                 const std::vector<Contact>& contacts, std::size_t first, std::size_t last, Flow& flow) {
  const Measured to{flow.share.data(), flow.secant.data(), flow.volume.normal.data(),
                    flow.volume.shear.data(), nullptr};
  (bonds.materials() == 1 ? measureAlike : measureMixed)(measureOf(near, particles, bonds, flow, contacts),
                                                         to, first, last);
}

void measureSecants(const StepInput& input, const std::vector<Contact>& contacts, const VectorField& u,
                    std::size_t first, std::size_t last, Secants& secants) {
  const Bonds& bonds = *input.bonds;
  Measure m = measureOf(input.near, input.particles, bonds, bonds.flow(), contacts);
  m.u = u.data();
  const Measured to{nullptr, secants.value.data(), nullptr, nullptr, secants.change.data()};
  (bonds.materials() == 1 ? measureMovedAlike : measureMovedMixed)(m, to, first, last);
}

}  // namespace tactile_clay::clay
