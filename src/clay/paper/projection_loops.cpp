#include "clay/paper/projection_loops.h"

#include "lanes/lanes.h"

namespace tactile_clay::clay::paper {
namespace {

constexpr float viscosity_relaxation = 0.125f;  // share of full corrections, see projection.cpp
// So that no distance is zero. Its square is added to squares, and lost in rounding beyond 10 um.
constexpr float tiny_distance = 1e-9f, tiny = tiny_distance * tiny_distance;  // m, m^2
// Of the cube of a third of the trace: a determinant of the moments below this is of neighbours in a plane.
constexpr float min_determinant = 0.02f;

/// Gradients of pairs: eight x, eight y and eight z in turn.
TACTILE_CLAY_INLINE LaneVector loadGradient(const float* gradient, std::uint32_t p) {
  const float* at = gradient + 3 * std::size_t{p};
  return {load(at), load(at + lane_width), load(at + 2 * lane_width)};
}
TACTILE_CLAY_INLINE void storeGradient(float* gradient, std::uint32_t p, const LaneVector& g) {
  float* at = gradient + 3 * std::size_t{p};
  store(at, g.x);
  store(at + lane_width, g.y);
  store(at + 2 * lane_width, g.z);
}

}  // namespace

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

TACTILE_CLAY_MULTIVERSION
void beginStrains(const Pairs pairs, const Strains s, std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; i += lane_width) {
    Totals<Symmetric> moments(last - i), weights(last - i);
    for (int k = 0; k < lane_width && i + k < last; ++k) {
      LaneVector total{};
      Symmetric moment{}, weight{};
      for (std::uint32_t p = pairs.begin[i + k]; p < pairs.end[i + k]; p += lane_width) {
        const LaneVector x = loadVector(pairs.x, pairs.y, pairs.z, p);
        const Lane r = max(load(pairs.distance + p), all(tiny_distance));
        const LaneVector g = times(s.kernel.slope(r) * (s.volume / r), x);
        storeGradient(s.gradient, p, g);
        add(total, g);
        addOuter(moment, g, x);
        addOuter(weight, times(gatherNumbers(s.inverse_mass, pairs.slot + p), g), g);
      }
      storeSlot(s.own_gradient + 4 * (i + k), sums(total));
      moments.set(k, moment);
      weights.set(k, weight);
    }
    LaneVector total{};
    const float* const own = s.own_gradient;
    for (int k = 0; k < lane_width && i + k < last; ++k) {
      total.x[k] = own[4 * (i + k)];
      total.y[k] = own[4 * (i + k) + 1];
      total.z[k] = own[4 * (i + k) + 2];
    }
    Symmetric weight = weights.get();
    addOuter(weight, times(load(s.inverse_mass + i), total), total);
    const Symmetric m = times(all(-1.0f), moments.get());
    const Symmetric cofactors{m.yy * m.zz - m.yz * m.yz, m.xx * m.zz - m.zx * m.zx,
                              m.xx * m.yy - m.xy * m.xy, m.xy * m.zx - m.xx * m.yz,
                              m.xy * m.yz - m.yy * m.zx, m.yz * m.zx - m.zz * m.xy};
    const Lane determinant = m.xx * cofactors.xx + m.xy * cofactors.xy + m.zx * cofactors.zx;
    const Lane scale = (m.xx + m.yy + m.zz) / 3.0f, wanted = load(s.compliance + i);
    // Where the neighbours do not span space, there is no velocity gradient to damp.
    const LaneOrder spans = (determinant > min_determinant * scale * scale * scale) & (wanted >= 0.0f);
    Viscosity& v = s.viscosities[i / lane_width];
    v.compliance = spans ? wanted : all(-1.0f);
    v.inverse = where(spans, times(1.0f / determinant, cofactors));
    const Columns inverse = columnsOf(v.inverse);
    v.weight = upperOf(times(inverse, times(columnsOf(weight), inverse)));
    v.multiplier = Symmetric{};
  }
}

TACTILE_CLAY_MULTIVERSION
void measureDensities(const Pairs pairs, const Densities d, const float* u, std::size_t first,
                      std::size_t last) {
  const Kernel& kernel = d.kernel;
  const float scale = 1.0f / d.lattice_sum, steepest = kernel.steepest() * scale;
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
        storeGradient(d.gradient, p, g);
        add(total.gradient, g);
        total.density += shape.value;
        total.weight += w * (shape.slope * shape.slope);
      }
      totals.set(k, total);
    }
    const Measured total = totals.get();
    const Lane error = (2.0f * total.density + 1.0f) * (kernel.sigma * scale) - 1.0f;
    const Lane weight =
        steepest * steepest * total.weight + load(d.inverse_mass + i) * dot(total.gradient, total.gradient);
    const LaneOrder pressing = (error > 0.0f) & (weight > 0.0f);
    store(d.step + i, pressing ? -load(d.share + i) * error / weight : Lane{});
  }
}

TACTILE_CLAY_MULTIVERSION
void moveByDensities(const Pairs pairs, const Densities d, std::size_t first, std::size_t last, float* u) {
  for (std::size_t i = first; i < last; ++i) {
    LaneVector move{};
    const Lane own = all(d.step[i]);
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width)
      add(move, times(own + gatherNumbers(d.step, pairs.slot + p), loadGradient(d.gradient, p)));
    storeSlot(u + 4 * i, slot(u + 4 * i) + u[4 * i + 3] * sums(move));
  }
}

namespace {

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
/// @param plain sums of Eq. 4, not corrected
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

}  // namespace

TACTILE_CLAY_MULTIVERSION
void measureStrains(const Pairs pairs, const Strains s, const float* u, std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; i += lane_width) {
    Totals<Columns> totals(last - i);  // of Eq. 4, sum_j (u_j - u_i) (V grad W)^T
    for (int k = 0; k < lane_width && i + k < last; ++k) {
      Columns total{};
      const LaneVector at = allOf(u + 4 * (i + k));
      for (std::uint32_t p = pairs.begin[i + k]; p < pairs.end[i + k]; p += lane_width) {
        const LaneVector of_other = gather(u, pairs.slot + p), g = loadGradient(s.gradient, p);
        const LaneVector to_other{of_other.x - at.x, of_other.y - at.y, of_other.z - at.z};
        add(total.x, times(g.x, to_other));
        add(total.y, times(g.y, to_other));
        add(total.z, times(g.z, to_other));
      }
      totals.set(k, total);
    }
    const Columns steps = resistStrains(totals.get(), s.viscosities[i / lane_width]);
    scatter(steps.x, s.step_xy + 8 * i, 8);
    scatter(steps.y, s.step_xy + 8 * i + 4, 8);
    scatter(steps.z, s.step_z + 4 * i, 4);
  }
}

namespace {

/// Gradients of eight pairs, to be summed with the steps' columns x and y of two pairs, and z of both, at
/// once.
struct HalfGradients {
  Lane low_xy, high_xy, z;
};
struct StepSums {
  Lane xy[2];  // in turn, so that none waits for the other
  Lane z;
};
/// Adds S_j g of pairs k and k + 4 of eight.
template <int k>
TACTILE_CLAY_INLINE void addSteps(const Strains& s, const std::uint32_t* slots, const HalfGradients& g,
                                  StepSums& sums) {
  const std::size_t low = slots[k], high = slots[k + 4];
  sums.xy[0] += spread<k>(g.low_xy) * load(s.step_xy + 2 * low);
  sums.xy[1] += spread<k>(g.high_xy) * load(s.step_xy + 2 * high);
  sums.z += spread<k>(g.z) * join(slot(s.step_z + low), slot(s.step_z + high));
}

}  // namespace

TACTILE_CLAY_MULTIVERSION
void moveByStrains(const Pairs pairs, const Strains s, std::size_t first, std::size_t last, float* u) {
  for (std::size_t i = first; i < last; ++i) {
    const float* total = s.own_gradient + 4 * i;
    StepSums sums{};
    sums.xy[0] = join(total[0] * slot(s.step_xy + 8 * i), total[1] * slot(s.step_xy + 8 * i + 4));
    sums.z = join(total[2] * slot(s.step_z + 4 * i), HalfLane{});
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width) {
      const float* at = s.gradient + 3 * std::size_t{p};
      const HalfGradients g{join(slot(at), slot(at + lane_width)),
                            join(slot(at + 4), slot(at + lane_width + 4)), load(at + 2 * lane_width)};
      const std::uint32_t* slots = pairs.slot + p;
      addSteps<0>(s, slots, g, sums);
      addSteps<1>(s, slots, g, sums);
      addSteps<2>(s, slots, g, sums);
      addSteps<3>(s, slots, g, sums);
    }
    storeSlot(u + 4 * i, slot(u + 4 * i) - u[4 * i + 3] * sumOfHalves(sums.xy[0] + sums.xy[1] + sums.z));
  }
}

TACTILE_CLAY_MULTIVERSION
void listBonds(const Pairs pairs, const float* pair_rest_length, const float* relaxation,
               const float* inverse_mass, std::size_t first, std::size_t last, const BondEnds ends) {
  for (std::size_t i = first; i < last; ++i) {
    std::uint32_t b = pairs.begin[i];
    for (std::uint32_t p = pairs.begin[i]; p < pairs.end[i]; p += lane_width) {
      const Lane rest_length = load(pair_rest_length + p);
      const unsigned mask = bits(rest_length > 0.0f);
      const LaneOrder& order = selections.order[mask];
      const std::uint32_t* slot = pairs.slot + p;
      const Lane share = min(all(relaxation[i]), gatherNumbers(relaxation, slot)) * inverse_mass[i] /
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

TACTILE_CLAY_MULTIVERSION
void pullEnds(const std::uint32_t* begin, const BondEnds ends, const float* u, std::size_t first,
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

}  // namespace tactile_clay::clay::paper
