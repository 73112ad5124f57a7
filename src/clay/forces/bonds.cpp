#include "clay/forces/bonds.h"

#include <algorithm>
#include <cmath>

#include "clay/threads.h"
#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

constexpr float sum_rounding = 1e-5f;  // relative, of a sum that is formed in another order

struct Rules {  // of eight pairs
  Lane bond_rate, unbond_rate;
};
TACTILE_CLAY_INLINE Rules rulesOf(const BondRule* rules, const std::uint32_t* index) {
  constexpr std::uint32_t stride = slot_size * sizeof(BondRule) / sizeof(float);
  std::uint32_t at[lane_width];
  for (int k = 0; k < lane_width; ++k) at[k] = index[k] * stride;
  return {gatherNumbers(&rules->bond_rate, at), gatherNumbers(&rules->unbond_rate, at)};
}

/// Writes a run of bonds, with the particles whose lanes are set in `mask`.
TACTILE_CLAY_INLINE void storeBonds(Bond* to, const std::uint32_t* slots, const Lane& rest_length,
                                    unsigned mask) {
  const LaneOrder& order = selections.order[mask];
  const LaneOrder index = select(load(slots), order) >> 2;  // divided by the size of a slot
  const Lane lengths = select(rest_length, order);
  Lane names;
  std::memcpy(&names, &index, sizeof names);
  static_assert(sizeof(Bond) == 8, "a bond is two lanes");
  const Lane low = TACTILE_CLAY_SHUFFLE(names, lengths, 0, 8, 1, 9, 2, 10, 3, 11);
  const Lane high = TACTILE_CLAY_SHUFFLE(names, lengths, 4, 12, 5, 13, 6, 14, 7, 15);
  std::memcpy(to, &low, sizeof low);
  std::memcpy(to + lane_width / 2, &high, sizeof high);
}

struct Update {
  NeighbourPairs pairs;
  const float* velocity;         // of all particles
  const std::uint8_t* material;  // of all particles
  float reach;                   // m, within which bonds form
};

/// Decides which pairs of particle i are bonded.
/// @param rules of its material with each material
/// @param old for each particle, the rest length of its bond to i so far; 0: no bond
/// @param rest_lengths gets the rest lengths of the pairs of i; 0: not bonded
/// @return the sum of their squares, m^2
template <bool alike>
TACTILE_CLAY_INLINE float activateBonds(const Update& u, std::size_t i, const BondRule* rules,
                                        const float* old, float* rest_lengths) {
  const Lane vx = all(u.velocity[4 * i]), vy = all(u.velocity[4 * i + 1]), vz = all(u.velocity[4 * i + 2]);
  const Lane reach = all(u.reach);
  constexpr std::uint32_t first[lane_width] = {};
  Rules rule = rulesOf(rules, first);
  Lane squares{};
  for (std::uint32_t p = u.pairs.begin[i]; p < u.pairs.end[i]; p += lane_width) {
    const std::uint32_t* slots = u.pairs.slot + p;
    const LaneVector x = loadVector(u.pairs.x, u.pairs.y, u.pairs.z, p);
    const Lane length = load(u.pairs.distance + p);
    if (!alike) {
      std::uint32_t index[lane_width];
      for (int k = 0; k < lane_width; ++k) index[k] = u.material[slots[k] / slot_size];
      rule = rulesOf(rules, index);
    }
    const Lane rest_length = gatherNumbers(old, slots);
    const LaneOrder bonded = rest_length > 0.0f;
    const LaneVector of_other = gather(u.velocity, slots);
    const Lane opening = (vx - of_other.x) * x.x + (vy - of_other.y) * x.y + (vz - of_other.z) * x.z;
    const Lane square = length * length, parting = opening < 0.0f ? -opening : opening;
    const LaneOrder forms = ~bonded & (length < reach) & (parting < rule.bond_rate * square);
    const LaneOrder holds = ((bonded & (parting <= rule.unbond_rate * square)) | forms) & (length > 0.0f);
    const Lane kept = holds ? (bonded ? rest_length : length) : Lane{};
    store(rest_lengths + p, kept);
    squares += kept * kept;
  }
  return sum(squares);
}

TACTILE_CLAY_MULTIVERSION
float activateAlike(const Update& u, std::size_t i, const BondRule* rules, const float* old,
                    float* rest_lengths) {
  return activateBonds<true>(u, i, rules, old, rest_lengths);
}
TACTILE_CLAY_MULTIVERSION
float activateMixed(const Update& u, std::size_t i, const BondRule* rules, const float* old,
                    float* rest_lengths) {
  return activateBonds<false>(u, i, rules, old, rest_lengths);
}

/// Elongations x E x / l of the strain tensors E, m.
TACTILE_CLAY_INLINE Lane elongationOf(const LaneVector& normal, const LaneVector& shear, const LaneVector& x,
                                      const Lane& length) {
  const Lane sum = normal.x * x.x * x.x + normal.y * x.y * x.y + normal.z * x.z * x.z +
                   2.0f * (shear.x * x.y * x.z + shear.y * x.z * x.x + shear.z * x.x * x.y);
  return length > 0.0f ? sum / length : Lane{};
}

/// Lets the rest lengths of the pairs of particle i flow.
/// @param bonds gets the bonds of the particle
/// @return their number
TACTILE_CLAY_MULTIVERSION
std::uint32_t flowAndList(const NeighbourPairs near, std::size_t i, const Flow& flow, float* rest_lengths,
                          Bond* bonds) {
  const Lane own_share = all(flow.share[i]);
  const float *const normal = flow.volume.normal.data(), *const shear = flow.volume.shear.data();
  const LaneVector own_normal = allOf(normal + slot_size * i), own_shear = allOf(shear + slot_size * i);
  const Lane own_stiffness = all(flow.stiffness[i]), own_before = all(flow.before[i]);
  std::uint32_t count = 0;
  for (std::uint32_t p = near.begin[i]; p < near.end[i]; p += lane_width) {
    const std::uint32_t* slots = near.slot + p;
    Lane rest_length = load(rest_lengths + p);
    const LaneOrder holds = rest_length > 0.0f;
    const Lane share = gatherNumbers(flow.share.data(), slots);
    const Lane stiffness = own_stiffness + gatherNumbers(flow.stiffness.data(), slots);
    const Lane before = own_before + gatherNumbers(flow.before.data(), slots);
    const LaneOrder stiffens = before < (1.0f - sum_rounding) * stiffness;
    if (bits(holds & ((share + own_share < 2.0f) | stiffens)) != 0) {
      const Lane length = load(near.distance + p), elongation = length - rest_length;
      const LaneVector x = loadVector(near.x, near.y, near.z, p);
      const Lane own = (1.0f - own_share) * (elongation - elongationOf(own_normal, own_shear, x, length));
      const Lane kept_of_other = elongationOf(gather(normal, slots), gather(shear, slots), x, length);
      const Lane of_other = (1.0f - share) * (elongation - kept_of_other);
      const Lane flowed = rest_length + 0.5f * (own + of_other);
      const Lane force_kept = stiffens ? before / stiffness : all(1.0f);
      const Lane stiffened = length - force_kept * (length - flowed);
      rest_length = holds ? max(stiffened, all(1e-6f) * length) : Lane{};
      store(rest_lengths + p, rest_length);
    }
    const unsigned mask = bits(holds);
    storeBonds(bonds + count, slots, rest_length, mask);
    count += selections.count[mask];
  }
  return count;
}

}  // namespace

Bonds::Bonds(float spacing, const std::vector<Material>& materials)
    : reach_(reach * spacing), materials_(materials.size()) {
  for (const Material& a : materials) {
    const double yield_stress = a.stiffness > 0.0 ? 2.0 * a.stiffness * a.yield_strain : INFINITY;
    yields_.push_back(static_cast<float>(yield_stress * std::pow(static_cast<double>(spacing), 3.0)));
    relaxation_rates_.push_back(static_cast<float>(1.0 / a.relaxation_time));
    for (const Material& b : materials) {
      const float stiffness = static_cast<float>(std::min(a.stiffness, b.stiffness) * spacing);
      rules_.push_back(
          {stiffness, stiffness > 0.0f ? static_cast<float>(std::min(a.bond_rate, b.bond_rate)) : -1.0f,
           stiffness > 0.0f ? static_cast<float>(std::min(a.unbond_rate, b.unbond_rate)) : -1.0f});
    }
  }
}

void Bonds::activate(const Neighbourhood& near, const Particles& particles, const VectorField& velocity,
                     bool form, std::size_t first, std::size_t last) {
  // Rest length of the bond between this particle and each other one. All are zero before the next particle.
  thread_local std::vector<float> rest_length_to;
  if (rest_length_to.size() < particles.size()) rest_length_to.resize(particles.size(), 0.0f);
  const float square = spacing() * spacing();
  const Update update{near.arrays(), velocity.data(), particles.material.data(), form ? reach_ : 0.0f};
  for (std::size_t i = first; i < last; ++i) {
    const Bond* const begin = before_.bonds.data() + before_.begin[i];
    const Bond* const end = before_.bonds.data() + before_.end[i];
    float squares = 0.0f;
    for (const Bond* b = begin; b != end; ++b) {
      rest_length_to[b->other] = b->rest_length;
      squares += b->rest_length * b->rest_length;
    }
    flow_.before[i] = bondStiffness(squares / square);
    squares = (materials_ == 1 ? activateAlike : activateMixed)(update, i, rules(particles.material[i]),
                                                                rest_length_to.data(), rest_lengths_.data());
    flow_.stiffness[i] = bondStiffness(squares / square);
    for (const Bond* b = begin; b != end; ++b) rest_length_to[b->other] = 0.0f;
  }
}

void Bonds::list(const Neighbourhood& near, std::size_t first, std::size_t last) {
  const NeighbourPairs pairs = near.arrays();
  for (std::size_t i = first; i < last; ++i) {
    const std::uint32_t begin = lists_.begin[i] = pairs.begin[i];
    lists_.end[i] = begin + flowAndList(pairs, i, flow_, rest_lengths_.data(), lists_.bonds.data() + begin);
  }
}

void Bonds::update(const Neighbourhood& near, const Particles& particles, const VectorField& velocity,
                   bool form, float duration, const std::vector<Contact>& contacts) {
  const std::size_t n = particles.size();
  std::swap(lists_, before_);
  before_.begin.resize(n, 0);
  before_.end.resize(n, 0);
  lists_.begin.resize(n);
  lists_.end.resize(n);
  lists_.bonds.resize(near.pairs());
  rest_lengths_.resize(near.pairs());
  flow_.resize(n);
  flow_.kept.clear();
  for (const float rate : relaxation_rates_) flow_.kept.push_back(std::exp(-duration * rate));
  parallelRanges(n, range_size, [&](std::size_t first, std::size_t last) {
    activate(near, particles, velocity, form, first, last);
  });
  parallelRanges(n, range_size, [&](std::size_t first, std::size_t last) {
    measureFlow(near, particles, *this, contacts, first, last, flow_);
  });
  parallelRanges(n, range_size, [&](std::size_t first, std::size_t last) { list(near, first, last); });
}

void Bonds::restore(const std::vector<std::uint32_t>& begins, std::vector<Bond> all) {
  lists_.begin.assign(begins.begin(), begins.end() - 1);
  lists_.end.assign(begins.begin() + 1, begins.end());
  lists_.bonds = std::move(all);
}

std::size_t Bonds::size() const {
  std::size_t ends = 0;
  for (std::size_t i = 0; i < lists_.begin.size(); ++i) ends += lists_.end[i] - lists_.begin[i];
  return ends / 2;
}

}  // namespace tactile_clay::clay
