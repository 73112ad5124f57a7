#include "clay/flow.h"

#include <algorithm>
#include <cmath>

#include "clay/bonds.h"
#include "clay/threads.h"
#include "lanes/lane_matrix.h"
#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

struct Measure {
  const std::uint32_t *begin, *end, *slot;
  const float *x, *y, *z, *rest_length;  // m
  const float* displacement;             // m, or null
  const std::uint8_t* material;          // of each particle
  const BondRule* rules;                 // of each two materials
  std::size_t materials;
  const float* yield;       // J, yield stress times volume, of each material
  const float* fading;      // time over relaxation time, of each material
  const float* fresh;       // J, Strained::square in the initial lattice, of each material
  float *share, *dilation;  // of each particle
};

/// What the bonds of a particle add up to.
struct Strained {
  Symmetric stress;  // J, twice the stress times volume
  Lane square;       // J, the trace of that where all bonds have a strain of one
};

template <bool alike>
TACTILE_CLAY_INLINE Strained strainedBonds(const Measure& m, std::size_t i) {
  const BondRule* const rules = m.rules + m.material[i] * m.materials;
  const Lane shortest = all(1e-18f);  // m^2
  Lane stiffness = all(rules[0].stiffness);
  LaneVector own{};
  if (m.displacement != nullptr) own = allOf(m.displacement + slot_size * i);
  Strained total{};
  for (std::uint32_t p = m.begin[i]; p < m.end[i]; p += lane_width) {
    LaneVector x = loadVector(m.x, m.y, m.z, p);
    if (m.displacement != nullptr) x = difference(x, difference(gather(m.displacement, m.slot + p), own));
    if (!alike)
      for (int k = 0; k < lane_width; ++k)
        stiffness[k] = rules[m.material[m.slot[p + k] / slot_size]].stiffness;
    const Lane rest_length = load(m.rest_length + p);
    const Lane bonded = rest_length > 0.0f ? stiffness : Lane{};
    const Lane square = greatest(dot(x, x), shortest);
    addOuter(total.stress, times(bonded * (1.0f - rest_length / root(square)), x), x);
    total.square += bonded * square;
  }
  return total;
}

template <bool alike>
TACTILE_CLAY_INLINE void measure(const Measure& m, std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; i += lane_width) {
    Totals<Strained> totals(last - i);
    Lane yield{}, kept = all(1.0f);
    for (int k = 0; k < lane_width && i + k < last; ++k) {
      yield[k] = m.yield[m.material[i + k]];
      totals.set(k, strainedBonds<alike>(m, i + k));
    }
    const Strained total = totals.get();
    for (int k = 0; k < lane_width && i + k < last; ++k) {
      const std::uint8_t material = m.material[i + k];
      if (m.fading[material] > 0.0f)
        kept[k] = std::exp(-m.fading[material] * std::max(total.square[k] / m.fresh[material], 1.0f));
    }
    const Symmetric& s = total.stress;
    const Lane trace = s.xx + s.yy + s.zz, mean = trace / 3.0f;
    const Lane xx = s.xx - mean, yy = s.yy - mean, zz = s.zz - mean;
    const Lane shear = s.yz * s.yz + s.zx * s.zx + s.xy * s.xy;
    const Lane size = 0.5f * root(0.5f * (xx * xx + yy * yy + zz * zz) + shear);  // J, |s| V
    store(m.share + i, kept * (size > yield ? yield / size : all(1.0f)));
    store(m.dilation + i, total.square > 0.0f ? trace / total.square : Lane{});
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

void measureFlow(const Neighbourhood& near, const Particles& particles, const Bonds& bonds,
                 const VectorField* displacements, float duration, Flow& flow) {
  const std::size_t n = particles.size();
  const std::size_t whole_lanes = (n + lane_width - 1) / lane_width * lane_width;
  flow.share.resize(whole_lanes), flow.dilation.resize(whole_lanes), flow.fading.clear();
  for (const float rate : bonds.relaxationRates()) flow.fading.push_back(duration * rate);
  const Measure m{near.begins(),
                  near.paddeds(),
                  near.slots(),
                  near.x(),
                  near.y(),
                  near.z(),
                  bonds.restLengths().data(),
                  displacements != nullptr ? displacements->data() : nullptr,
                  particles.material.data(),
                  bonds.rules(0),
                  bonds.materials(),
                  bonds.yields().data(),
                  flow.fading.data(),
                  bonds.fresh().data(),
                  flow.share.data(),
                  flow.dilation.data()};
  parallelRanges(n, range_size, [&](std::size_t first, std::size_t last) {
    (bonds.materials() == 1 ? measureAlike : measureMixed)(m, first, last);
  });
}

}  // namespace tactile_clay::clay
