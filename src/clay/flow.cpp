#include "clay/flow.h"

#include "clay/bonds.h"
#include "lanes/lane_matrix.h"
#include "lanes/lanes.h"

namespace tactile_clay::clay {
namespace {

struct Measure {
  const std::uint32_t *begin, *end, *slot;
  const float *x, *y, *z, *length, *rest_length;  // m
  const std::uint8_t* material;                   // of each particle
  const BondRule* rules;                          // of each two materials
  std::size_t materials;
  const float* yield;       // J, yield stress times volume, of each material
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
  Lane stiffness = all(rules[0].stiffness);
  Strained total{};
  for (std::uint32_t p = m.begin[i]; p < m.end[i]; p += lane_width) {
    const Lane rest_length = load(m.rest_length + p);
    const LaneOrder bonded = rest_length > 0.0f;  // which coincident particles are not
    if (!alike) {
      float of[lane_width];
      for (int k = 0; k < lane_width; ++k) of[k] = rules[m.material[m.slot[p + k] / slot_size]].stiffness;
      stiffness = load(of);
    }
    const LaneVector x = loadVector(m.x, m.y, m.z, p);
    const Lane length = load(m.length + p), strain = 1.0f - rest_length / length;
    addOuter(total.stress, times(bonded ? stiffness * strain : Lane{}, x), x);
    total.square += bonded ? stiffness * (length * length) : Lane{};
  }
  return total;
}

template <bool alike>
TACTILE_CLAY_INLINE void measure(const Measure& m, std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; i += lane_width) {
    Totals<Strained> totals(last - i);
    Lane yield{};
    for (int k = 0; k < lane_width && i + k < last; ++k) {
      yield[k] = m.yield[m.material[i + k]];
      totals.set(k, strainedBonds<alike>(m, i + k));
    }
    const Strained total = totals.get();
    const Symmetric& s = total.stress;
    const Lane trace = s.xx + s.yy + s.zz, mean = trace / 3.0f;
    const Lane xx = s.xx - mean, yy = s.yy - mean, zz = s.zz - mean;
    const Lane shear = s.yz * s.yz + s.zx * s.zx + s.xy * s.xy;
    const Lane size = 0.5f * root(0.5f * (xx * xx + yy * yy + zz * zz) + shear);  // J, |s| V
    store(m.share + i, size > yield ? yield / size : all(1.0f));
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

void Flow::resize(std::size_t particles) {
  const std::size_t whole_lanes = (particles + lane_width - 1) / lane_width * lane_width;
  share.resize(whole_lanes), dilation.resize(whole_lanes);
}

void measureFlow(const Neighbourhood& near, const Particles& particles, const Bonds& bonds, std::size_t first,
                 std::size_t last, Flow& flow) {
  const Measure m{near.begins(),
                  near.paddeds(),
                  near.slots(),
                  near.x(),
                  near.y(),
                  near.z(),
                  near.distances(),
                  bonds.restLengths().data(),
                  particles.material.data(),
                  bonds.rules(0),
                  bonds.materials(),
                  bonds.yields().data(),
                  flow.share.data(),
                  flow.dilation.data()};
  (bonds.materials() == 1 ? measureAlike : measureMixed)(m, first, last);
}

}  // namespace tactile_clay::clay
