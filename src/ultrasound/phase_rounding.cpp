#include "ultrasound/phase_rounding.h"

#include <cmath>

namespace tactile_clay::ultrasound {
namespace {

/// Effect of each transducer on the amplitudes of the foci, sixteen foci per element: if it is turned by
/// delta, |p_m| changes by re (cos delta - 1) - im sin delta.
struct Effects {
  std::size_t width;             // elements per transducer
  LaneArray<ComplexLanes> lane;  // transducer by transducer

  Effects(const Propagator& g, const DriveLanes& q, const FocusField& p);
};

TACTILE_CLAY_MULTIVERSION void addFocus(const ComplexLanes* row, const DriveLanes& q, float re, float im,
                                        std::size_t m, Effects& effects) {
  float along[wide_lane_count];
  float across[wide_lane_count];
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Lanes a = row[i].re * q[i].re - row[i].im * q[i].im;
    const Lanes b = row[i].re * q[i].im + row[i].im * q[i].re;
    const Lanes radial = re * a + im * b;
    const Lanes tangential = re * b - im * a;
    std::memcpy(along, &radial, sizeof along);
    std::memcpy(across, &tangential, sizeof across);
    for (std::size_t n = 0; n < wide_lane_count; ++n) {
      ComplexLanes& effect = effects.lane[(i * wide_lane_count + n) * effects.width + m / wide_lane_count];
      effect.re[m % wide_lane_count] = along[n];
      effect.im[m % wide_lane_count] = across[n];
    }
  }
}

Effects::Effects(const Propagator& g, const DriveLanes& q, const FocusField& p)
    : width(lanesFor(g.foci)), lane(g.width * wide_lane_count * width, ComplexLanes{}) {
  const Eigen::ArrayXf scale = p.abs().max(1e-20f).inverse();
  for (std::size_t m = 0; m < g.foci; ++m) {
    const auto k = static_cast<Eigen::Index>(m);
    addFocus(g.row(m), q, p.re(k) * scale(k), p.im(k) * scale(k), m, *this);
  }
}

/// A level that a transducer may take, and the turn to it.
struct Candidates {
  LaneArray<Lanes> level, cosine, sine;

  explicit Candidates(std::size_t width) : level(width), cosine(width), sine(width) {}
};

TACTILE_CLAY_MULTIVERSION void chooseLevels(const Effects& effects, const Candidates& low,
                                            const Candidates& high, std::size_t transducers, Lanes* error,
                                            Lanes* level) {
  for (std::size_t n = 0; n < transducers; ++n) {
    const std::size_t i = n / wide_lane_count;
    const std::size_t lane = n % wide_lane_count;
    const float low_cosine = low.cosine[i][lane] - 1.0f;
    const float low_sine = low.sine[i][lane];
    const float high_cosine = high.cosine[i][lane] - 1.0f;
    const float high_sine = high.sine[i][lane];
    const ComplexLanes* effect = &effects.lane[n * effects.width];
    Lanes gain{};  // change of the sum of squares if the higher level is taken
    for (std::size_t f = 0; f < effects.width; ++f) {
      const Lanes down = effect[f].re * low_cosine - effect[f].im * low_sine;
      const Lanes up = effect[f].re * high_cosine - effect[f].im * high_sine;
      gain += (up - down) * (2.0f * error[f] + up + down);
    }
    const float higher = sum(gain) < 0.0f ? 1.0f : 0.0f;  // without a branch, which could not be predicted
    const float cosine = low_cosine + higher * (high_cosine - low_cosine);
    const float sine = low_sine + higher * (high_sine - low_sine);
    for (std::size_t f = 0; f < effects.width; ++f) {
      error[f] += effect[f].re * cosine - effect[f].im * sine;
    }
    level[i][lane] = low.level[i][lane] + higher * (high.level[i][lane] - low.level[i][lane]);
  }
}

TACTILE_CLAY_INLINE Lanes magnitude(Lanes a) {
  return a < 0.0f ? -a : a;
}

}  // namespace

LaneArray<Lanes> limitPhases(const PhaseLimit& limit, DriveLanes& q) {
  LaneArray<Lanes> free(q.size());
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Lanes turns = turnsOf(q[i].re, q[i].im);
    Lanes change = turns - limit.before[i];
    change -= nearest(change);
    const LaneBits within = magnitude(change) <= limit.change[i];
    const Lanes bounded = max(min(change, limit.change[i]), -limit.change[i]);
    Lanes cosine;
    Lanes sine;
    unitCircle(limit.before[i] + bounded, cosine, sine);
    const Lanes squared = q[i].re * q[i].re + q[i].im * q[i].im;
    const Lanes amplitude = squared * inverseRoot(max(squared, Lanes{} + 1e-30f));
    q[i].re = within ? q[i].re : amplitude * cosine;
    q[i].im = within ? q[i].im : amplitude * sine;
    free[i] = within ? Lanes{} + 1.0f : Lanes{};
  }
  return free;
}

namespace {

/// The two levels closest to each phase. If only one of them is within the limit, both candidates are that
/// level; if none is, both are the level closest to the phase before.
TACTILE_CLAY_MULTIVERSION void findCandidates(const DriveLanes& q, float steps, const PhaseLimit* limit,
                                              Candidates& low, Candidates& high) {
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Lanes at = turnsOf(q[i].re, q[i].im) * steps;
    Lanes down = nearest(at - 0.5f);
    Lanes up = down + 1.0f;
    if (limit != nullptr) {
      Lanes change = down / steps - limit->before[i];
      change -= nearest(change);
      const LaneBits low_allowed = magnitude(change) <= limit->change[i] + 1e-5f;
      change = up / steps - limit->before[i];
      change -= nearest(change);
      const LaneBits high_allowed = magnitude(change) <= limit->change[i] + 1e-5f;
      const Lanes stay = nearest(limit->before[i] * steps);
      down = low_allowed ? down : (high_allowed ? up : stay);
      up = high_allowed ? up : down;
    }
    low.level[i] = down;
    high.level[i] = up;
    unitCircle((down - at) / steps, low.cosine[i], low.sine[i]);
    unitCircle((up - at) / steps, high.cosine[i], high.sine[i]);
  }
}

/// Brings levels into 0 to steps - 1.
TACTILE_CLAY_MULTIVERSION void wrapLevels(float steps, LaneArray<Lanes>& level) {
  for (Lanes& l : level) {
    l -= steps * nearest(l / steps - 0.5f);
    l = l >= steps ? l - steps : (l < 0.0f ? l + steps : l);
  }
}

}  // namespace

LaneArray<Lanes> roundPhases(const Propagator& g, const DriveLanes& q, int levels, const PhaseLimit* limit) {
  FocusField p(g.foci);
  propagate(g, q, p);
  const auto steps = static_cast<float>(levels);
  Candidates low(g.width);
  Candidates high(g.width);
  findCandidates(q, steps, limit, low, high);
  const Effects effects(g, q, p);
  LaneArray<Lanes> error(effects.width, Lanes{});
  LaneArray<Lanes> level(g.width);
  chooseLevels(effects, low, high, g.width * wide_lane_count, error.data(), level.data());
  wrapLevels(steps, level);
  return level;
}

}  // namespace tactile_clay::ultrasound
