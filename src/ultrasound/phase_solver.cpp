#include "ultrasound/phase_solver.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>
#include <string>

namespace tactile_clay::ultrasound {
namespace {

constexpr float tiny = 1e-20f;            // keeps divisions by an amplitude finite
constexpr double least_intensity = 1e-3;  // weaker foci are lost between the others

/// A complex array as two real ones: Eigen vectorises that better than interleaved numbers.
template <typename Array>
struct Complex {
  Array re, im;

  Complex(Eigen::Index rows, Eigen::Index cols) : re(rows, cols), im(rows, cols) {}
  auto abs() const { return (re.array().square() + im.array().square()).sqrt(); }
};
using ComplexMatrix = Complex<Eigen::MatrixXf>;

/// Scales each number to absolute value 1.
void normalise(ComplexMatrix& z) {
  const Eigen::ArrayXf scale = z.abs().max(tiny).inverse();
  z.re.array() *= scale;
  z.im.array() *= scale;
}

/// p = G^T q, foci from transducers.
void propagate(const ComplexMatrix& g, const ComplexMatrix& q, ComplexMatrix& p) {
  p.re.noalias() = g.re.transpose() * q.re;
  p.re.noalias() -= g.im.transpose() * q.im;
  p.im.noalias() = g.re.transpose() * q.im;
  p.im.noalias() += g.im.transpose() * q.re;
}

/// q = conj(G) p: back from the foci.
void backpropagate(const ComplexMatrix& g, const ComplexMatrix& p, ComplexMatrix& q) {
  q.re.noalias() = g.re * p.re;
  q.re.noalias() += g.im * p.im;
  q.im.noalias() = g.re * p.im;
  q.im.noalias() -= g.im * p.re;
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

void check(const std::vector<FocalPoint>& points, const PhaseSolverOptions& options) {
  if (options.iterations < 1 || options.iterations > 1000) {
    throw std::invalid_argument("phase solver: iterations is " + std::to_string(options.iterations) +
                                ", expected 1 to 1000");
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
}

}  // namespace

double focusPressure(const ArrayLayout& layout, const Acoustics& acoustics, const Eigen::Vector3d& point) {
  double sum = 0.0;
  for (std::size_t n = 0; n < layout.size(); ++n)
    sum += std::abs(transducerPressure(layout, acoustics, n, point));
  return sum;
}

PhaseSolution solvePhases(const ArrayLayout& layout, const Acoustics& acoustics,
                          const std::vector<FocalPoint>& points, const PhaseSolverOptions& options,
                          const Drive* warm_start) {
  check(points, options);
  const auto n = static_cast<Eigen::Index>(layout.size());
  if (warm_start != nullptr && (warm_start->phase.size() != layout.size() ||
                                !std::all_of(warm_start->phase.begin(), warm_start->phase.end(),
                                             [](float x) { return std::isfinite(x); }))) {
    throw std::invalid_argument("phase solver: warm start has " + std::to_string(warm_start->phase.size()) +
                                " phases, expected " + std::to_string(layout.size()) + ", all finite");
  }
  PhaseSolution solution;
  solution.target.assign(points.size(), 0.0);
  solution.reached.assign(points.size(), 0.0);
  solution.drive.phase.assign(layout.size(), 0.0f);
  solution.drive.amplitude.assign(layout.size(), 0.0f);

  // Propagator, each focus scaled by its target: then every focus has to reach 1.
  std::vector<std::size_t> active;  // points that take part, a column each
  ComplexMatrix g(n, static_cast<Eigen::Index>(points.size()));
  std::vector<std::complex<double>> pressure(layout.size());
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (points[k].intensity < least_intensity) continue;
    double reach = 0.0;  // focusPressure
    for (std::size_t i = 0; i < layout.size(); ++i) {
      pressure[i] = transducerPressure(layout, acoustics, i, points[k].position);
      reach += std::abs(pressure[i]);
    }
    if (!(reach > 0.0)) continue;
    solution.target[k] = points[k].intensity * reach;  // over sqrt(M) below
    const auto column = static_cast<Eigen::Index>(active.size());
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto scaled = pressure[static_cast<std::size_t>(i)] / solution.target[k];
      g.re(i, column) = static_cast<float>(scaled.real());
      g.im(i, column) = static_cast<float>(scaled.imag());
    }
    active.push_back(k);
  }
  if (active.empty()) return solution;
  const auto m = static_cast<Eigen::Index>(active.size());
  const double sharing = std::sqrt(static_cast<double>(m));
  for (const std::size_t k : active) solution.target[k] /= sharing;
  g.re = (g.re.leftCols(m) * static_cast<float>(sharing)).eval();
  g.im = (g.im.leftCols(m) * static_cast<float>(sharing)).eval();

  ComplexMatrix q(n, 1);
  ComplexMatrix p(m, 1);
  p.re.setOnes();
  p.im.setZero();
  if (warm_start != nullptr) {
    for (Eigen::Index i = 0; i < n; ++i) {
      q.re(i, 0) = std::cos(warm_start->phase[static_cast<std::size_t>(i)]);
      q.im(i, 0) = std::sin(warm_start->phase[static_cast<std::size_t>(i)]);
    }
    propagate(g, q, p);
  }
  // In the scaled propagator a focus starts with the weight of its target squared: q = sum of conj(G) target.
  Eigen::ArrayXf first(m);
  for (Eigen::Index j = 0; j < m; ++j) {
    first(j) = static_cast<float>(std::pow(points[active[static_cast<std::size_t>(j)]].intensity, 2));
  }
  Weights weights(first);
  const int iterations = m == 1 ? 1 : options.iterations;
  for (int pass = 0; pass < iterations; ++pass) {
    normalise(p);
    p.re.array() *= weights.value;
    p.im.array() *= weights.value;
    backpropagate(g, p, q);
    normalise(q);
    propagate(g, q, p);
    weights.update(p.abs().max(tiny));
  }

  // The weakest focus sets how far all can be lowered: none may end below its target.
  const float weakest = p.abs().minCoeff();
  const float amplitude = std::min(1.0f / std::max(weakest, tiny), 1.0f);
  for (Eigen::Index i = 0; i < n; ++i) {
    const float phase = std::atan2(q.im(i, 0), q.re(i, 0));
    solution.drive.phase[static_cast<std::size_t>(i)] =
        phase < 0.0f ? phase + static_cast<float>(2.0 * M_PI) : phase;
    solution.drive.amplitude[static_cast<std::size_t>(i)] = amplitude;
  }
  const Eigen::ArrayXf reached = p.abs() * amplitude;
  for (Eigen::Index j = 0; j < m; ++j) {
    const std::size_t k = active[static_cast<std::size_t>(j)];
    solution.reached[k] = reached(j) * solution.target[k];
  }
  return solution;
}

}  // namespace tactile_clay::ultrasound
