#include "ultrasound/focus_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

namespace tactile_clay::ultrasound {
namespace {

constexpr int ascent_passes = 10;
constexpr float poor = 0.01f;              // error of the worst amplitude above which other starts are tried
constexpr std::size_t more_starts = 6;     // at most wide_lane_count - 1
constexpr double min_norm_damping = 1e-3;  // for foci that no drive can separate
constexpr int limited_rounds = 3;

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

/// Sets the amplitude of each drive to 1.
TACTILE_CLAY_MULTIVERSION void normalise(DriveLanes& q) {
  for (ComplexLanes& a : q) {
    const Lanes scale = inverseRoot(max(a.re * a.re + a.im * a.im, Lanes{} + 1e-30f));
    a.re *= scale;
    a.im *= scale;
  }
}

/// Divides each drive by the mean of their amplitudes, and limits its amplitude to 1.
TACTILE_CLAY_MULTIVERSION void moderate(DriveLanes& q, std::size_t transducers) {
  Lanes total{};
  for (const ComplexLanes& a : q) {
    const Lanes squared = max(a.re * a.re + a.im * a.im, Lanes{} + 1e-30f);
    total += squared * inverseRoot(squared);
  }
  const float over_mean = static_cast<float>(transducers) / sum(total);
  for (ComplexLanes& a : q) {
    const Lanes squared = max(a.re * a.re + a.im * a.im, Lanes{} + 1e-30f);
    const Lanes scale = min(inverseRoot(squared), Lanes{} + over_mean);
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
    for (std::size_t lane = 1; lane < wide_lane_count; ++lane)
      turns[lane] = static_cast<float>(std::fmod(0.7548776662 * static_cast<double>((m + 1) * lane) +
                                                     0.5698402910 * static_cast<double>(m * m * lane),
                                                 1.0));
    unitCircle(turns, unit[m].re, unit[m].im);
  }
  return unit;
}

/// Turns the phases of sources c, |c| = weight, one after the other to where they add most to the power c^H R
/// c, sixteen starts at once.
/// @param r R, foci x foci
/// @param source in: c with amplitudes 1; out: c
/// @param power out: power of each start
TACTILE_CLAY_MULTIVERSION void ascend(const Eigen::MatrixXcf& r, const Eigen::ArrayXf& weight, int passes,
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
      const Lanes squared = max(re * re + im * im, Lanes{} + 1e-30f);
      const Lanes over = inverseRoot(squared);
      const float w = weight.data()[m];
      source[m] = {w * over * re, w * over * im};
      power += w * squared * over;
    }
  }
}

}  // namespace

FocusSolver::FocusSolver(Propagator g, std::size_t transducers, double wavenumber,
                         std::vector<FocusShape> shapes, const PhaseSolverOptions& options)
    : g_(std::move(g)),
      transducers_(transducers),
      wavenumber_(wavenumber),
      options_(options),
      shapes_(std::move(shapes)),
      q_(g_.width),
      p_(g_.foci) {}

void FocusSolver::start(const DriveLanes& q) {
  propagate(g_, q, p_);
  const Eigen::Array<bool, Eigen::Dynamic, 1> silent = p_.abs() <= tiny_amplitude;
  warm_ = !silent.all();
  p_.re = silent.select(1.0f, p_.re);
}

void FocusSolver::solve(const Eigen::ArrayXf& power) {
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
      if (worstError(p_.abs()) > poor) startAnew();
      break;
  }
}

void FocusSolver::limit(const PhaseLimit& limit, const DriveLanes& before) {
  Lanes re{};
  Lanes im{};
  for (std::size_t i = 0; i < q_.size(); ++i) {
    re += before[i].re * q_[i].re + before[i].im * q_[i].im;
    im += before[i].im * q_[i].re - before[i].re * q_[i].im;
  }
  const std::complex<float> all(sum(re), sum(im));
  const std::complex<float> by = std::abs(all) > tiny_amplitude ? all / std::abs(all) : 1.0f;
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

FocusField FocusSolver::p() const {
  FocusField p(g_.foci);
  propagate(g_, q_, p);
  return p;
}

/// Computes q from the phases of the foci and these weights.
void FocusSolver::emit(const Eigen::ArrayXf& weight) {
  const Eigen::ArrayXf scale = weight / p_.abs().max(tiny_amplitude);
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

void FocusSolver::gerchbergSaxton(const Eigen::ArrayXf& first, int passes) {
  Weights weights(first);
  for (int pass = 0; pass < passes; ++pass) {
    emit(weights.value);
    weights.update(p_.abs().max(tiny_amplitude));
  }
}

/// Phases of the foci by iteration in G F.
/// @return weights for `emit`
Eigen::ArrayXf FocusSolver::amongFoci(int passes) {
  const Eigen::MatrixXcf r = gram(g_);
  const Eigen::ArrayXf over_energy = r.diagonal().real().array().max(tiny_amplitude).inverse();
  Eigen::VectorXcf p(p_.re.size());
  p.real() = p_.re.matrix();
  p.imag() = p_.im.matrix();
  Eigen::VectorXcf source(p.size());
  for (int pass = 0; pass < passes; ++pass) {
    source = p.array() * (over_energy / p.array().abs().max(tiny_amplitude)).cast<std::complex<float>>();
    p.noalias() = r * source;
  }
  p_.re = p.real().array();
  p_.im = p.imag().array();
  return over_energy / p_.abs().max(tiny_amplitude);
}

/// Phases of the foci that give the most power, the best of sixteen starts.
/// @return weights for `emit`
Eigen::ArrayXf FocusSolver::strongest() {
  const Eigen::MatrixXcf r = gram(g_);
  const Eigen::ArrayXf over_energy = r.diagonal().real().array().max(tiny_amplitude).inverse();
  LaneArray<ComplexLanes> source = scattered(g_.foci);
  Lanes power;
  ascend(r, over_energy, ascent_passes, source.data(), power);
  std::size_t best = 0;
  for (std::size_t lane = 1; lane < wide_lane_count; ++lane)
    if (power[lane] > power[best]) best = lane;
  Eigen::VectorXcf c(p_.re.size());
  for (std::size_t m = 0; m < g_.foci; ++m)
    c(static_cast<Eigen::Index>(m)) = {source[m].re[best], source[m].im[best]};
  const Eigen::VectorXcf p = r * c;
  p_.re = p.real().array();
  p_.im = p.imag().array();
  return over_energy / p_.abs().max(tiny_amplitude);
}

/// A weak focus on the axis of a strong one, above it, gets far too much pressure from all drives that give
/// much power, and no small change helps. So this function starts from other drives: those of minimum norm
/// that give each focus its amplitude at some phase, q = G^H (G G^H)^-1 p, each brought to amplitude 1. It
/// keeps the best.
void FocusSolver::startAnew() {
  Eigen::MatrixXcd r = gram(g_).cast<std::complex<double>>();
  r.diagonal() *= 1.0 + min_norm_damping;
  const Eigen::LLT<Eigen::MatrixXcd> by(r);
  const LaneArray<ComplexLanes> phases = scattered(g_.foci);
  DriveLanes best = q_;
  float minimum = worstError(p_.abs());
  for (std::size_t start = 1; start <= more_starts && minimum > poor; ++start) {
    Eigen::VectorXcd source(p_.re.size());
    for (std::size_t m = 0; m < g_.foci; ++m)
      source(static_cast<Eigen::Index>(m)) = {phases[m].re[start], phases[m].im[start]};
    by.solveInPlace(source);
    if (!source.allFinite()) break;
    p_.re = source.real().cast<float>().array();
    p_.im = source.imag().cast<float>().array();
    emit(p_.abs());
    correct(LaneArray<Lanes>(g_.width, Lanes{} + 1.0f));
    const float error = worstError(p_.abs());
    if (!(error < minimum)) continue;
    minimum = error;
    best = q_;
  }
  q_ = best;
  propagate(g_, q_, p_);
}

void FocusSolver::correct(const LaneArray<Lanes>& free) {
  newtonSteps(g_, wavenumber_, free, shapes_, q_, p_);
}

}  // namespace tactile_clay::ultrasound
