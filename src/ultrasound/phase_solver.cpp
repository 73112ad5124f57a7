#include "ultrasound/phase_solver.h"

#include <Eigen/Cholesky>
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
constexpr int gram_passes = 30;
constexpr int newton_steps = 12;
constexpr float newton_tolerance = 5e-4f;  // of an amplitude: below it single precision gains nothing
constexpr double peak_tolerance = 3e-4;    // m, from a focus to the peak of its amplitude
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

/// Solves p = G q for |p| = 1 at every focus, up to a common scale.
class Solver {
 public:
  Solver(const Propagator& g, std::size_t transducers, double wavenumber, const PhaseSolverOptions& options)
      : g_(g),
        transducers_(transducers),
        options_(options),
        q_(g.width),
        p_(g.foci),
        most_slope_(static_cast<float>(wavenumber * peak_tolerance)) {}

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
        gerchbergSaxton(power);
        break;
      case PhaseMethod::gs_pat:
        emit(amongFoci(options_.iterations));
        break;
      case PhaseMethod::newton:
        gerchbergSaxton(warm_ ? power : amongFoci(gram_passes));
        correct(LaneArray<Lanes>(g_.width, Lanes{} + 1.0f));
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

  void gerchbergSaxton(const Eigen::ArrayXf& first) {
    Weights weights(first);
    for (int pass = 0; pass < options_.iterations; ++pass) {
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

  static float spread(const Eigen::ArrayXf& amplitude) {
    return (amplitude / std::max(amplitude.mean(), tiny) - 1.0f).square().mean();
  }

  static float worst(const Eigen::ArrayXf& amplitude) {
    return (amplitude / std::max(amplitude.mean(), tiny) - 1.0f).abs().maxCoeff();
  }

  /// Newton steps of the free phases, damped further (Levenberg-Marquardt) until the error falls: all
  /// amplitudes the same and, where foci are to be peaks, no slope that moves a peak too far.
  void correct(const LaneArray<Lanes>& free) {
    FocusChange now;
    FocusChange after;
    DriveLanes trial;
    FocusField reached(g_.foci);
    propagate(g_, q_, p_);
    focusChange(g_, q_, p_, free, options_.peaks, now);
    std::vector<bool> held(static_cast<std::size_t>(now.slope.size()), false);  // slopes that were too large
    std::vector<const Lanes*> rows;
    std::vector<double> wanted;
    double damping = 1e-5;  // foci that no drive can tell apart must not turn it wildly
    Eigen::MatrixXd products;
    bool moved = true;
    for (int step = 0; step < newton_steps; ++step) {
      if (worst(now.amplitude) < newton_tolerance && (tooLarge(now) == 0.0f).all()) return;
      if (moved) {
        rows.clear();
        wanted.clear();
        const float mean = now.amplitude.mean();
        for (std::size_t m = 0; m < g_.foci; ++m) {
          rows.push_back(&now.j[m * g_.width]);
          wanted.push_back(mean - now.amplitude(static_cast<Eigen::Index>(m)));
        }
        const Eigen::ArrayXf excess = tooLarge(now);
        for (std::size_t k = 0; k < held.size(); ++k) {
          held[k] = held[k] || excess(static_cast<Eigen::Index>(k)) != 0.0f;
          if (!held[k]) continue;
          rows.push_back(&now.j[(g_.foci + k) * g_.width]);
          wanted.push_back(-now.slope(static_cast<Eigen::Index>(k)));
        }
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
      focusChange(g_, trial, reached, free, options_.peaks, after);
      moved = fault(after) < fault(now);
      damping *= moved ? 0.1 : 10.0;
      if (!moved) continue;
      q_.swap(trial);
      std::swap(p_, reached);
      std::swap(now, after);
    }
  }

  /// What of each slope moves a peak by more than the tolerance.
  Eigen::ArrayXf tooLarge(const FocusChange& change) const {
    constexpr float flat = 1e-4f;  // no peak at all
    const Eigen::ArrayXf bound = most_slope_ * change.peak_width.max(flat);
    return change.slope - change.slope.max(-bound).min(bound);
  }

  float fault(const FocusChange& change) const {
    constexpr float weight = 3.0f;  // of slopes, whose s is some 0.3
    return spread(change.amplitude) +
           (change.slope.size() > 0 ? weight * tooLarge(change).square().mean() : 0.0f);
  }

  const Propagator& g_;
  std::size_t transducers_;
  const PhaseSolverOptions& options_;
  DriveLanes q_;
  FocusField p_;
  bool warm_ = false;
  float most_slope_;  // over peak width
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
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (points[k].intensity < least_intensity) continue;
    const float reach = g.addFocus(transducers, acoustics, points[k].position);
    if (!(reach > 0.0f)) continue;
    solution.target[k] = points[k].intensity * reach;  // over sqrt(M) below
    active.push_back(k);
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

  Solver solver(g, layout.size(), acoustics.wavenumber(), options);
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
