#include "ultrasound/phase_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <stdexcept>
#include <string>

#include "ultrasound/phase_rounding.h"
#include "ultrasound/propagator.h"

namespace tactile_clay::ultrasound {
namespace {

constexpr float tiny = 1e-20f;            // keeps divisions by an amplitude finite
constexpr double least_intensity = 1e-3;  // weaker foci are lost between the others
constexpr auto two_pi = static_cast<float>(2.0 * M_PI);
constexpr auto over_turn = static_cast<float>(0.5 / M_PI);
constexpr int ascent_passes = 10;
constexpr int newton_steps = 40;
constexpr float newton_tolerance = 5e-4f;    // of an amplitude: below it single precision gains nothing
constexpr double peak_tolerance = 7e-4;      // m, from a focus to the peak of its amplitude
constexpr float least_width = 0.35f;         // of a peak's parabola, over that of a focus that is alone
constexpr double resolvable = 1.5;           // separation below which two foci cannot both be peaks
constexpr int peak_steps = 15;               // after which peaks are given up where they could not be had
constexpr double first_damping = 1e-5;       // foci that no drive can tell apart must not turn it wildly
constexpr double most_damping = 1e3;         // beyond it no step helps
constexpr float poor = 0.01f;                // error of the worst amplitude that calls for another start
constexpr std::size_t more_starts = 6;       // at most lane_count - 1
constexpr double least_norm_damping = 1e-3;  // of foci that no drive can tell apart
constexpr int limited_rounds = 3;

const std::map<std::string, PhaseMethod>& methods() {
  static const std::map<std::string, PhaseMethod> known = {
      {"naive", PhaseMethod::naive},
      {"weighted_gerchberg_saxton", PhaseMethod::weighted_gerchberg_saxton},
      {"gs_pat", PhaseMethod::gs_pat},
      {"newton", PhaseMethod::newton}};
  return known;
}

void requireRange(const char* name, int value, int low, int high, bool zero) {
  if ((value >= low && value <= high) || (zero && value == 0)) return;
  throw std::invalid_argument("phase solver: " + std::string(name) + " is " + std::to_string(value) +
                              ", expected " + std::to_string(low) + " to " + std::to_string(high) +
                              (zero ? ", or 0" : ""));
}

void check(const ArrayLayout& layout, const std::vector<FocalPoint>& points,
           const PhaseSolverOptions& options, const Drive* before) {
  requireRange("iterations", options.iterations, 1, 1000, false);
  requireRange("phase_levels", options.phase_levels, 2, 65536, true);
  requireRange("amplitude_levels", options.amplitude_levels, 1, 65536, true);
  if (!(options.max_phase_change >= 0.0)) {
    throw std::invalid_argument("phase solver: max_phase_change is " +
                                std::to_string(options.max_phase_change) + ", expected at least 0");
  }
  for (const FocalPoint& point : points) {
    if (!point.position.allFinite()) {
      throw std::invalid_argument("phase solver: position of focal point " + std::to_string(point.id) +
                                  " is not finite");
    }
    if (!(point.intensity >= 0.0 && point.intensity <= 1.0)) {
      throw std::invalid_argument("phase solver: intensity of focal point " + std::to_string(point.id) +
                                  " is " + std::to_string(point.intensity) + ", expected 0 to 1");
    }
  }
  if (before != nullptr &&
      (before->phase.size() != layout.size() || before->amplitude.size() != layout.size() ||
       !std::all_of(before->phase.begin(), before->phase.end(),
                    [](float x) { return std::abs(x) < 1e4f; }))) {
    throw std::invalid_argument("phase solver: the drive before has " + std::to_string(before->phase.size()) +
                                " phases, expected " + std::to_string(layout.size()) +
                                ", each within 10000 rad");
  }
}

/// Weights of the foci: w *= (mean |p| / |p|)^e, where the exponent e of a focus shrinks when its error
/// changes sign and grows while it does not.
struct Weights {
  Eigen::ArrayXf value, exponent, error;

  explicit Weights(const Eigen::ArrayXf& first)
      : value(first / first.mean()),
        exponent(Eigen::ArrayXf::Constant(first.size(), 0.7f)),
        error(Eigen::ArrayXf::Zero(first.size())) {}

  void update(const Eigen::ArrayXf& amplitude) {
    const Eigen::ArrayXf last = error;
    error = (amplitude.mean() / amplitude).log();
    exponent = (error * last < 0.0f).select(0.7f * exponent, (1.2f * exponent).min(1.5f));
    value *= (exponent * error).exp();
    value /= value.mean();
  }
};

/// Each drive to amplitude 1.
TACTILE_CLAY_CLONES void normalise(DriveLanes& q) {
  for (ComplexLanes& a : q) {
    const Lanes scale = inverseRoot(larger(a.re * a.re + a.im * a.im, Lanes{} + 1e-30f));
    a.re *= scale;
    a.im *= scale;
  }
}

/// Each drive over the mean of their amplitudes, at most 1.
TACTILE_CLAY_CLONES void moderate(DriveLanes& q, std::size_t transducers) {
  Lanes total{};
  for (const ComplexLanes& a : q) {
    const Lanes squared = larger(a.re * a.re + a.im * a.im, Lanes{} + 1e-30f);
    total += squared * inverseRoot(squared);
  }
  const float over_mean = static_cast<float>(transducers) / sum(total);
  for (ComplexLanes& a : q) {
    const Lanes squared = larger(a.re * a.re + a.im * a.im, Lanes{} + 1e-30f);
    const Lanes scale = smaller(inverseRoot(squared), Lanes{} + over_mean);
    a.re *= scale;
    a.im *= scale;
  }
}

/// Units of sixteen phases for each focus: lane 0 has all foci in phase, the others scatter them evenly
/// (additive recurrence).
LaneArray<ComplexLanes> scattered(std::size_t foci) {
  LaneArray<ComplexLanes> unit(foci);
  for (std::size_t m = 0; m < foci; ++m) {
    Lanes turns{};
    for (std::size_t lane = 1; lane < lane_count; ++lane)
      turns[lane] = static_cast<float>(std::fmod(0.7548776662 * static_cast<double>((m + 1) * lane) +
                                                     0.5698402910 * static_cast<double>(m * m * lane),
                                                 1.0));
    unitCircle(turns, unit[m].re, unit[m].im);
  }
  return unit;
}

/// Turns the phases of sources c, |c| = weight, one after the other to where they add most to the power
/// c^H R c, sixteen starts at once. \param r R, foci x foci \param source in: unit; out: c \param power of
/// each
TACTILE_CLAY_CLONES void ascend(const Eigen::MatrixXcf& r, const Eigen::ArrayXf& weight, int passes,
                                ComplexLanes* source, Lanes& power) {
  const auto foci = static_cast<std::size_t>(weight.size());
  const std::complex<float>* column = r.data();
  for (std::size_t m = 0; m < foci; ++m) {
    const float w = weight.data()[m];
    source[m] = {w * source[m].re, w * source[m].im};
  }
  for (int pass = 0; pass < passes; ++pass) {
    power = Lanes{};
    for (std::size_t m = 0; m < foci; ++m) {
      Lanes re{};
      Lanes im{};
      for (std::size_t k = 0; k < foci; ++k) {  // R is Hermitian: row m is the conjugate of column m
        if (k == m) continue;
        const float a = column[m * foci + k].real();
        const float b = -column[m * foci + k].imag();
        re += a * source[k].re - b * source[k].im;
        im += a * source[k].im + b * source[k].re;
      }
      const Lanes squared = larger(re * re + im * im, Lanes{} + 1e-30f);
      const Lanes over = inverseRoot(squared);
      const float w = weight.data()[m];
      source[m] = {w * over * re, w * over * im};
      power += w * squared * over;
    }
  }
}

/// Rows of J of the free phases only. \param free 1 where a phase may change, 0 where not
TACTILE_CLAY_CLONES void mask(const LaneArray<Lanes>& free, std::size_t rows, LaneArray<Lanes>& j) {
  for (std::size_t k = 0; k < rows; ++k) {
    for (std::size_t i = 0; i < free.size(); ++i) j[k * free.size() + i] *= free[i];
  }
}

/// Turns each drive by the sum of lambda times its row, as an angle up to third order.
TACTILE_CLAY_CLONES void turnBy(const Lanes* const* rows, const float* lambda, std::size_t count,
                                DriveLanes& q) {
  constexpr float most = 0.5f;  // rad a step: J holds nearby only
  for (std::size_t i = 0; i < q.size(); ++i) {
    Lanes angle{};
    for (std::size_t m = 0; m < count; ++m) angle += lambda[m] * rows[m][i];
    angle = larger(smaller(angle, Lanes{} + most), Lanes{} - most);
    const Lanes cosine = inverseRoot(1.0f + angle * angle);
    const Lanes sine = angle * cosine;
    const ComplexLanes a = q[i];
    q[i] = {a.re * cosine - a.im * sine, a.re * sine + a.im * cosine};
  }
}

/// A focus as the solver sees it.
struct FocusShape {
  bool peak;    // whether it is to be one
  float width;  // of its parabola when it is alone
};

/// Solves p = G q for |p| = 1 at every focus, up to a common scale.
class Solver {
 public:
  /// \param shapes of the foci; empty: amplitudes are all that counts
  Solver(const Propagator& g, std::size_t transducers, double wavenumber, std::vector<FocusShape> shapes,
         const PhaseSolverOptions& options)
      : g_(g),
        transducers_(transducers),
        options_(options),
        shapes_(std::move(shapes)),
        q_(g.width),
        p_(g.foci),
        most_aside_(static_cast<float>(wavenumber * peak_tolerance)) {}

  /// From the phases that this drive has at the foci.
  void start(const DriveLanes& q) {
    propagate(g_, q, p_);
    const Eigen::Array<bool, Eigen::Dynamic, 1> silent = p_.abs() <= tiny;
    warm_ = !silent.all();
    p_.re = silent.select(1.0f, p_.re);
  }

  /// \param power weights that give equal foci in G^H w: target squared
  void solve(const Eigen::ArrayXf& power) {
    switch (g_.foci == 1 ? PhaseMethod::naive : options_.method) {
      case PhaseMethod::naive:
        emit(power);
        break;
      case PhaseMethod::weighted_gerchberg_saxton:
        gerchbergSaxton(power, options_.iterations);
        break;
      case PhaseMethod::gs_pat:
        emit(amongFoci(options_.iterations));
        break;
      case PhaseMethod::newton:
        gerchbergSaxton(warm_ ? power : strongest(), options_.iterations);
        correct(LaneArray<Lanes>(g_.width, Lanes{} + 1.0f));
        if (worst(p_.abs()) > poor) startAnew();
        break;
    }
  }

  /// Turns all drives together to be as close as they can to the drive before, then each to its limit.
  void limit(const PhaseLimit& limit, const DriveLanes& before) {
    Lanes re{};
    Lanes im{};
    for (std::size_t i = 0; i < q_.size(); ++i) {
      re += before[i].re * q_[i].re + before[i].im * q_[i].im;
      im += before[i].im * q_[i].re - before[i].re * q_[i].im;
    }
    const std::complex<float> all(sum(re), sum(im));
    const std::complex<float> by = std::abs(all) > tiny ? all / std::abs(all) : 1.0f;
    for (ComplexLanes& a : q_) {
      a = {a.re * by.real() - a.im * by.imag(), a.re * by.imag() + a.im * by.real()};
    }
    LaneArray<Lanes> free = limitPhases(limit, q_);
    for (int round = 0; options_.method == PhaseMethod::newton && round < limited_rounds; ++round) {
      correct(free);
      const LaneArray<Lanes> now = limitPhases(limit, q_);
      for (std::size_t i = 0; i < free.size(); ++i) free[i] *= now[i];
    }
    propagate(g_, q_, p_);
  }

  DriveLanes& q() { return q_; }
  const FocusField& p() {
    propagate(g_, q_, p_);
    return p_;
  }

 private:
  /// q from the phases of the foci and these weights.
  void emit(const Eigen::ArrayXf& weight) {
    const Eigen::ArrayXf scale = weight / p_.abs().max(tiny);
    p_.re *= scale;
    p_.im *= scale;
    backpropagate(g_, p_, q_);
    if (options_.phase_only) {
      normalise(q_);
    } else {
      moderate(q_, transducers_);
    }
    propagate(g_, q_, p_);
  }

  void gerchbergSaxton(const Eigen::ArrayXf& first, int passes) {
    Weights weights(first);
    for (int pass = 0; pass < passes; ++pass) {
      emit(weights.value);
      weights.update(p_.abs().max(tiny));
    }
  }

  /// Phases of the foci by iteration in G F. \return weights for `emit`
  Eigen::ArrayXf amongFoci(int passes) {
    const Eigen::MatrixXcf r = gram(g_);
    const Eigen::ArrayXf over_energy = r.diagonal().real().array().max(tiny).inverse();
    Eigen::VectorXcf p(p_.re.size());
    p.real() = p_.re.matrix();
    p.imag() = p_.im.matrix();
    Eigen::VectorXcf source(p.size());
    for (int pass = 0; pass < passes; ++pass) {
      source = p.array() * (over_energy / p.array().abs().max(tiny)).cast<std::complex<float>>();
      p.noalias() = r * source;
    }
    p_.re = p.real().array();
    p_.im = p.imag().array();
    return over_energy / p_.abs().max(tiny);
  }

  /// Phases of the foci that give the most power, the best of sixteen starts. \return weights for `emit`
  Eigen::ArrayXf strongest() {
    const Eigen::MatrixXcf r = gram(g_);
    const Eigen::ArrayXf over_energy = r.diagonal().real().array().max(tiny).inverse();
    LaneArray<ComplexLanes> source = scattered(g_.foci);
    Lanes power;
    ascend(r, over_energy, ascent_passes, source.data(), power);
    std::size_t best = 0;
    for (std::size_t lane = 1; lane < lane_count; ++lane)
      if (power[lane] > power[best]) best = lane;
    Eigen::VectorXcf c(p_.re.size());
    for (std::size_t m = 0; m < g_.foci; ++m)
      c(static_cast<Eigen::Index>(m)) = {source[m].re[best], source[m].im[best]};
    const Eigen::VectorXcf p = r * c;
    p_.re = p.real().array();
    p_.im = p.imag().array();
    return over_energy / p_.abs().max(tiny);
  }

  /// A weak focus above a strong one, on its axis, gets far too much from all drives that give much power,
  /// and no small change helps. Starts from others: those of least norm that give each focus its amplitude at
  /// some phase, q = G^H (G G^H)^-1 p, each brought to amplitude 1. Keeps the best.
  void startAnew() {
    Eigen::MatrixXcd r = gram(g_).cast<std::complex<double>>();
    r.diagonal() *= 1.0 + least_norm_damping;
    const Eigen::LLT<Eigen::MatrixXcd> by(r);
    const LaneArray<ComplexLanes> phases = scattered(g_.foci);
    DriveLanes best = q_;
    float least = worst(p_.abs());
    for (std::size_t start = 1; start <= more_starts && least > poor; ++start) {
      Eigen::VectorXcd source(p_.re.size());
      for (std::size_t m = 0; m < g_.foci; ++m)
        source(static_cast<Eigen::Index>(m)) = {phases[m].re[start], phases[m].im[start]};
      by.solveInPlace(source);
      if (!source.allFinite()) break;
      p_.re = source.real().cast<float>().array();
      p_.im = source.imag().cast<float>().array();
      emit(p_.abs());
      correct(LaneArray<Lanes>(g_.width, Lanes{} + 1.0f));
      const float error = worst(p_.abs());
      if (!(error < least)) continue;
      least = error;
      best = q_;
    }
    q_ = best;
    propagate(g_, q_, p_);
  }

  static float spread(const Eigen::ArrayXf& amplitude) {
    return (amplitude / std::max(amplitude.mean(), tiny) - 1.0f).square().mean();
  }

  static float worst(const Eigen::ArrayXf& amplitude) {
    return (amplitude / std::max(amplitude.mean(), tiny) - 1.0f).abs().maxCoeff();
  }

  /// What keeps focus m from being a peak close enough to its place.
  struct PeakFault {
    PeakShape shape;
    Eigen::Vector2f narrowest = Eigen::Vector2f::UnitX();  // unit vector along which its parabola is flattest
    float lacking = 0.0f;                                  // width along it, over that of a lone focus
    float near = 1.0f;                                     // share of the slope that it may have, at most 1
  };

  struct State {
    FocusParts parts;
    std::vector<PeakFault> peak;  // of each focus where shapes_ has any
    float fault = 0.0f;           // mean square error of amplitudes, and of slopes and widths as they count
    bool good = false;
  };

  void assess(const DriveLanes& q, const FocusField& p, State& state) const {
    constexpr float slope_weight = 3.0f;  // of slopes, whose s is some 0.3
    constexpr float width_weight = 0.03f;
    focusParts(g_, q, p, state.parts);
    state.fault = spread(state.parts.amplitude);
    state.good = worst(state.parts.amplitude) < newton_tolerance;
    state.peak.resize(shapes_.size());
    const float over_foci = 1.0f / static_cast<float>(g_.foci);
    for (std::size_t m = 0; m < shapes_.size(); ++m) {
      if (!shapes_[m].peak) continue;
      PeakFault& peak = state.peak[m];
      peak = PeakFault();
      peak.shape = peakShape(g_, state.parts, m);
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2f> along;
      along.computeDirect(peak.shape.width);
      const float least = least_width * shapes_[m].width;
      peak.lacking = std::max(1.0f - along.eigenvalues()(0) / least, 0.0f);
      peak.narrowest = along.eigenvectors().col(0);
      const Eigen::Vector2f aside = (along.eigenvectors().transpose() * peak.shape.slope).array() /
                                    along.eigenvalues().array().max(least);
      peak.near = std::min(most_aside_ / std::max(aside.norm(), tiny), 1.0f);
      if (peak.lacking > 0.0f || peak.near < 1.0f) state.good = false;
      state.fault += over_foci * (slope_weight * ((1.0f - peak.near) * peak.shape.slope).squaredNorm() +
                                  width_weight * peak.lacking * peak.lacking);
    }
  }

  /// Asks no more for peaks that could not be had, so that the amplitudes can be. \return whether there were
  /// any
  bool giveUpPeaks(const State& state) {
    bool any = false;
    for (std::size_t m = 0; m < shapes_.size(); ++m) {
      const PeakFault& peak = state.peak[m];
      if (!shapes_[m].peak || (peak.lacking == 0.0f && peak.near == 1.0f)) continue;
      shapes_[m].peak = false;
      any = true;
    }
    return any;
  }

  /// Newton steps of the free phases, damped further (Levenberg-Marquardt) until the error falls: all
  /// amplitudes the same and, where foci are to be peaks, no slope that moves a peak too far and no parabola
  /// that is too flat.
  void correct(const LaneArray<Lanes>& free) {
    constexpr float well_near = 0.6f;  // of what is allowed, so that one step brings it within
    constexpr float well_wide = 1.3f;
    State now;
    State after;
    DriveLanes trial;
    FocusField reached(g_.foci);
    propagate(g_, q_, p_);
    assess(q_, p_, now);
    std::vector<bool> slope_held(shapes_.size(), false);  // that was too large once
    LaneArray<Lanes> j;
    std::vector<const Lanes*> rows;
    std::vector<double> wanted;
    double damping = first_damping;
    Eigen::MatrixXd products;
    bool moved = true;
    for (int step = 0; step < newton_steps && !now.good; ++step) {
      if (damping > most_damping || step == peak_steps) {
        if (giveUpPeaks(now)) {
          assess(q_, p_, now);
          damping = first_damping;
          moved = true;
        } else if (damping > most_damping) {
          return;
        }
      }
      if (moved) {
        wanted.clear();
        j.resize((g_.foci + 3 * shapes_.size()) * g_.width);
        const auto row = [&] { return &j[wanted.size() * g_.width]; };
        const float mean = now.parts.amplitude.mean();
        std::copy(now.parts.across.begin(), now.parts.across.end(), j.begin());
        for (std::size_t m = 0; m < g_.foci; ++m)
          wanted.push_back(mean - now.parts.amplitude(static_cast<Eigen::Index>(m)));
        for (std::size_t m = 0; m < shapes_.size(); ++m) {
          if (!shapes_[m].peak) continue;
          const PeakFault& peak = now.peak[m];
          if (peak.lacking > 0.0f) {
            widthRow(g_, now.parts, m, peak.shape, peak.narrowest, row());
            wanted.push_back(least_width * shapes_[m].width * (well_wide - 1.0f + peak.lacking));
          }
          slope_held[m] = slope_held[m] || peak.near < 1.0f;
          if (!slope_held[m]) continue;
          const float keep = peak.near < 1.0f ? well_near * peak.near : 1.0f;
          for (const Eigen::Vector2f& u : {Eigen::Vector2f(1.0f, 0.0f), Eigen::Vector2f(0.0f, 1.0f)}) {
            slopeRow(g_, now.parts, m, peak.shape, u, row());
            wanted.push_back((keep - 1.0f) * peak.shape.slope.dot(u));
          }
        }
        rows.clear();
        for (std::size_t k = 0; k < wanted.size(); ++k) rows.push_back(&j[k * g_.width]);
        mask(free, rows.size(), j);
        products = rowProducts(rows, g_.width);
      }
      Eigen::MatrixXd damped = products;
      damped.diagonal() *= 1.0 + damping;
      damped.diagonal().array() += 1e-30;
      const Eigen::VectorXf lambda =
          damped.llt().solve(Eigen::Map<const Eigen::VectorXd>(wanted.data(), products.rows())).cast<float>();
      if (!lambda.allFinite()) return;
      trial = q_;
      turnBy(rows.data(), lambda.data(), rows.size(), trial);
      propagate(g_, trial, reached);
      assess(trial, reached, after);
      moved = after.fault < now.fault;
      damping *= moved ? 0.1 : 10.0;
      if (!moved) continue;
      q_.swap(trial);
      std::swap(p_, reached);
      std::swap(now, after);
    }
  }

  const Propagator& g_;
  std::size_t transducers_;
  const PhaseSolverOptions& options_;
  std::vector<FocusShape> shapes_;
  DriveLanes q_;
  FocusField p_;
  bool warm_ = false;
  float most_aside_;  // k times the way from a focus to its peak
};

/// A drive in lanes.
DriveLanes driveLanes(const Drive& drive, std::size_t width) {
  LaneArray<Lanes> turns(width, Lanes{});
  LaneArray<Lanes> amplitude(width, Lanes{});
  for (std::size_t n = 0; n < drive.phase.size(); ++n) {
    turns[n / lane_count][n % lane_count] = drive.phase[n] * over_turn;
    amplitude[n / lane_count][n % lane_count] = drive.amplitude[n];
  }
  DriveLanes q(width);
  for (std::size_t i = 0; i < width; ++i) {
    unitCircle(turns[i], q[i].re, q[i].im);
    q[i].re *= amplitude[i];
    q[i].im *= amplitude[i];
  }
  return q;
}

PhaseLimit phaseLimit(const Drive& before, double most, std::size_t width) {
  PhaseLimit limit{LaneArray<Lanes>(width, Lanes{}), LaneArray<Lanes>(width, Lanes{} + 1.0f)};
  for (std::size_t n = 0; n < before.phase.size(); ++n) {
    limit.before[n / lane_count][n % lane_count] = before.phase[n] * over_turn;
    if (before.amplitude[n] > 0.0f) {
      limit.change[n / lane_count][n % lane_count] =
          static_cast<float>(std::min(most, 2.0 * M_PI)) * over_turn;
    }
  }
  return limit;
}

TACTILE_CLAY_INLINE Lanes amplitudeOf(const ComplexLanes& a) {
  const Lanes squared = a.re * a.re + a.im * a.im;
  return squared * inverseRoot(larger(squared, Lanes{} + 1e-30f));
}

/// Lowers the drive to what the weakest focus needs.
void lower(const FocusField& p, DriveLanes& q) {
  const float factor = std::min(1.0f / std::max(p.abs().minCoeff(), tiny), 1.0f);
  for (ComplexLanes& a : q) {
    a.re *= factor;
    a.im *= factor;
  }
}

/// Amplitudes to the levels of the device: a common one up, so that no focus falls below its target; others
/// to the nearest.
TACTILE_CLAY_CLONES void roundAmplitudes(int levels, bool up, DriveLanes& q) {
  const auto steps = static_cast<float>(levels);
  for (ComplexLanes& a : q) {
    const Lanes amplitude = amplitudeOf(a);
    const Lanes at = amplitude * steps + (up ? 0.5f - 1e-4f : 0.0f);
    const Lanes rounded = smaller(nearest(at), Lanes{} + steps) / steps;
    const Lanes factor = rounded / larger(amplitude, Lanes{} + 1e-10f);
    a.re *= factor;
    a.im *= factor;
  }
}

/// Turns each drive to its level.
TACTILE_CLAY_CLONES void setPhases(const LaneArray<Lanes>& level, int levels, DriveLanes& q) {
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Lanes amplitude = amplitudeOf(q[i]);
    unitCircle(level[i] * (1.0f / static_cast<float>(levels)), q[i].re, q[i].im);
    q[i].re *= amplitude;
    q[i].im *= amplitude;
  }
}

/// \param level where phases were rounded, else null
Drive driveOf(const DriveLanes& q, std::size_t transducers, const LaneArray<Lanes>* level, int levels) {
  Drive drive{std::vector<float>(transducers), std::vector<float>(transducers)};
  for (std::size_t i = 0, n = 0; n < transducers; ++i) {
    const Lanes turns = turnsOf(q[i].re, q[i].im);
    const Lanes amplitude = smaller(amplitudeOf(q[i]), Lanes{} + 1.0f);
    const Lanes positive = turns < 0.0f ? turns + 1.0f : turns;
    const Lanes phase =
        level == nullptr ? two_pi * positive : (*level)[i] * two_pi / static_cast<float>(levels);
    for (std::size_t lane = 0; lane < lane_count && n < transducers; ++lane, ++n) {
      drive.phase[n] = phase[lane];
      drive.amplitude[n] = amplitude[lane];
    }
  }
  return drive;
}

}  // namespace

PhaseMethod phaseMethod(const std::string& name) {
  const auto found = methods().find(name);
  if (found != methods().end()) return found->second;
  std::string known;
  for (const auto& entry : methods()) known += (known.empty() ? "" : ", ") + entry.first;
  throw std::invalid_argument("unknown phase method '" + name + "', expected one of: " + known);
}

double focusPressure(const ArrayLayout& layout, const Acoustics& acoustics, const Eigen::Vector3d& point) {
  double total = 0.0;
  for (std::size_t n = 0; n < layout.size(); ++n)
    total += std::abs(transducerPressure(layout, acoustics, n, point));
  return total;
}

PhaseSolution solvePhases(const ArrayLayout& layout, const Acoustics& acoustics,
                          const std::vector<FocalPoint>& points, const PhaseSolverOptions& options,
                          const Drive* before) {
  check(layout, points, options, before);
  PhaseSolution solution;
  solution.target.assign(points.size(), 0.0);
  solution.reached.assign(points.size(), 0.0);
  solution.drive.phase.assign(layout.size(), 0.0f);
  solution.drive.amplitude.assign(layout.size(), 0.0f);

  // Each row over its target: then every focus has to reach 1.
  const TransducerLanes transducers(layout);
  Propagator g(points.size(), transducers.x.size());
  std::vector<std::size_t> active;  // points that take part, a row each
  std::vector<FocusBeam> beams;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (points[k].intensity < least_intensity) continue;
    const FocusBeam beam = g.addFocus(transducers, acoustics, points[k].position);
    if (!(beam.reach > 0.0f)) continue;
    solution.target[k] = points[k].intensity * beam.reach;  // over sqrt(M) below
    active.push_back(k);
    beams.push_back(beam);
  }
  if (active.empty()) return solution;
  const double sharing = std::sqrt(static_cast<double>(active.size()));
  Eigen::ArrayXf power(static_cast<Eigen::Index>(active.size()));
  for (std::size_t m = 0; m < active.size(); ++m) {
    double& target = solution.target[active[m]];
    target /= sharing;
    g.scaleRow(m, static_cast<float>(1.0 / target));
    power(static_cast<Eigen::Index>(m)) = static_cast<float>(std::pow(points[active[m]].intensity, 2));
  }

  const double k = acoustics.wavenumber();
  std::vector<FocusShape> shapes;
  for (std::size_t m = 0; options.peaks && active.size() > 1 && m < active.size(); ++m) {
    FocusShape shape{true, 0.5f * beams[m].spread.topLeftCorner<2, 2>().trace()};
    for (std::size_t n = 0; n < active.size(); ++n) {
      const Eigen::Vector3d way = points[active[n]].position - points[active[m]].position;
      if (n != m && separation(way, beams[m], beams[n], k) < resolvable) shape.peak = false;
    }
    shapes.push_back(shape);
  }
  Solver solver(g, layout.size(), k, std::move(shapes), options);
  DriveLanes last;
  PhaseLimit limit;
  const bool limited = before != nullptr && options.max_phase_change > 0.0;
  if (before != nullptr) {
    last = driveLanes(*before, g.width);
    solver.start(last);
  }
  solver.solve(power);
  if (limited) {
    limit = phaseLimit(*before, options.max_phase_change, g.width);
    solver.limit(limit, last);
  }
  DriveLanes& q = solver.q();
  const bool own_amplitudes = !options.phase_only && options.amplitude_levels > 0;
  if (own_amplitudes) {
    lower(solver.p(), q);
    roundAmplitudes(options.amplitude_levels, false, q);
  }
  LaneArray<Lanes> level;
  if (options.phase_levels > 0) {
    level = roundPhases(g, q, options.phase_levels, limited ? &limit : nullptr);
    setPhases(level, options.phase_levels, q);
  }
  if (!own_amplitudes) {
    lower(solver.p(), q);
    if (options.amplitude_levels > 0) roundAmplitudes(options.amplitude_levels, true, q);
  }
  solution.drive = driveOf(q, layout.size(), level.empty() ? nullptr : &level, options.phase_levels);
  const FocusField& reached = solver.p();
  const Eigen::ArrayXf share = reached.abs();
  for (std::size_t m = 0; m < active.size(); ++m) {
    solution.reached[active[m]] = share(static_cast<Eigen::Index>(m)) * solution.target[active[m]];
  }
  return solution;
}

}  // namespace tactile_clay::ultrasound
