#include "tools/material_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <map>
#include <stdexcept>

#include "tools/nelder_mead.h"

namespace tactile_clay::tools {
namespace {

using clay::Material;

// Share of the root mean square force; larger residuals count by their size, not by its square.
constexpr double stray = 0.1;
constexpr double edges[] = {0.5, 0.25};  // of a logarithm, for the first simplex and for the second one
constexpr double done = 0.01;            // of a logarithm: parameters within 1 %
constexpr double shift = 0.3;      // of a logarithm, for sensitivities: much larger than the clay's noise
constexpr double min_bulk = 10.0;  // in units of the stiffness
constexpr double wrong = 1e6;      // loss of a material that gives no forces
const double undetermined = std::log(1.5);  // standard error of a logarithm

/// How the fit reads and sets a parameter, and its bounds.
struct Access {
  double low, high;
  std::function<double(const Material&)> get;
  std::function<void(Material&, double)> set;
};
double yieldStress(const Material& m) {
  return 2.0 * m.stiffness * m.yield_strain;
}
const std::map<std::string, Access> accesses = {
    // The yield stress stays the same when the stiffness changes.
    {"stiffness",
     {1e2, 1e8, [](const Material& m) { return m.stiffness; },
      [](Material& m, double v) {
        m.yield_strain *= m.stiffness / v;
        m.stiffness = v;
        m.bulk_modulus = std::max(m.bulk_modulus, min_bulk * v);
      }}},
    {"yield_stress",
     {1.0, 1e8, yieldStress, [](Material& m, double v) { m.yield_strain = 0.5 * v / m.stiffness; }}},
    {"viscosity",
     {0.1, 1e6, [](const Material& m) { return m.viscosity; },
      [](Material& m, double v) { m.viscosity = v; }}},
    {"relaxation_time",
     {0.01, 1e4, [](const Material& m) { return m.relaxation_time; },
      [](Material& m, double v) { m.relaxation_time = v; }}},
    {"friction",
     {0.01, 10.0, [](const Material& m) { return m.friction; },
      [](Material& m, double v) { m.friction = m.skin_friction = v; }}}};

double rootMeanSquare(const std::vector<double>& numbers) {
  double sum = 0.0;
  for (const double x : numbers) sum += x * x;
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(numbers.size(), 1)));
}

std::vector<double> difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> d(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) d[k] = a[k] - b[k];
  return d;
}

Material withValues(Material m, const std::vector<std::string>& names, const Point& logarithms) {
  for (std::size_t k = 0; k < names.size(); ++k) {
    const Access& access = accesses.at(names[k]);
    access.set(m, std::clamp(std::exp(logarithms[k]), access.low, access.high));
  }
  return m;
}

/// Sum of the squared distances of logarithms from their bounds.
double beyondBounds(const std::vector<std::string>& names, const Point& logarithms) {
  double sum = 0.0;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const Access& access = accesses.at(names[k]);
    const double inside = std::clamp(logarithms[k], std::log(access.low), std::log(access.high));
    sum += std::pow(logarithms[k] - inside, 2.0);
  }
  return sum;
}

std::string number(double value) {
  char text[32];
  if (std::isinf(value)) return ".inf";
  std::snprintf(text, sizeof text, "%.4g", value);
  // In YAML 1.1 a number with an exponent needs a point.
  std::string yaml = text;
  const std::size_t e = yaml.find('e');
  if (e != std::string::npos && yaml.find('.') == std::string::npos) yaml.insert(e, ".0");
  return yaml;
}

/// @throws std::runtime_error with one line if these parameters of the material cannot be fitted
void requireFittable(const Material& start, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (accesses.count(name) == 0)
      throw std::runtime_error(
          "parameter '" + name +
          "', expected some of stiffness, yield_stress, viscosity, relaxation_time, friction");
  if (names.empty()) throw std::runtime_error("no parameter to fit, expected at least one");
  if (!(start.stiffness > 0.0))
    throw std::runtime_error("material '" + start.name + "' has no stiffness, expected one to start from");
}

bool isFitted(const std::vector<std::string>& names, const char* name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Standard errors of the parameters' logarithms (Gauss & Newton). With m residuals r and their slopes J by n
/// parameters, the covariance is |r|^2 / (m - n) (J^T J)^-1.
/// @param run forces at a point
/// @param best where the fit ended
/// @param left residuals there, N
/// @param scale root mean square of the forces, N
std::vector<double> standardErrors(const std::function<std::vector<double>(const Point&)>& run,
                                   const Point& best, const std::vector<double>& left, double scale) {
  const auto m = static_cast<Eigen::Index>(left.size()), n = static_cast<Eigen::Index>(best.size());
  Eigen::MatrixXd slopes(m, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    Point up = best, down = best;
    up[static_cast<std::size_t>(k)] += shift;
    down[static_cast<std::size_t>(k)] -= shift;
    const std::vector<double> d = difference(run(up), run(down));
    for (Eigen::Index i = 0; i < m; ++i) slopes(i, k) = d[static_cast<std::size_t>(i)] / (2.0 * shift);
  }
  double squares = 0.0;
  for (const double r : left) squares += r * r;
  const Eigen::VectorXd lengths = slopes.colwise().norm().cwiseMax(1e-12 * scale);
  const Eigen::MatrixXd unit = slopes * lengths.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd inverse =
      (unit.transpose() * unit + 1e-12 * Eigen::MatrixXd::Identity(n, n)).inverse();
  std::vector<double> errors;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double variance = squares / static_cast<double>(std::max<Eigen::Index>(m - n, 1)) * inverse(k, k) /
                            std::pow(lengths[k], 2.0);
    errors.push_back(std::sqrt(variance));
  }
  return errors;
}

}  // namespace

bool FitParameter::determined() const {
  return error < undetermined;
}

MaterialFit fitMaterial(const ForceModel& forces, const std::vector<double>& measured,
                        const clay::Material& start, double yield_stress,
                        const std::vector<std::string>& names, int maximum) {
  requireFittable(start, names);
  const double scale = rootMeanSquare(measured);
  MaterialFit fit;
  fit.measured = measured;
  const auto run = [&](const Point& at) {
    ++fit.evaluations;
    return forces(withValues(fit.material, names, at));
  };
  const auto loss = [&](const Point& at) {
    double sum = 0.0;
    for (const double r : difference(run(at), measured)) {
      const double x = r / (stray * scale);
      sum += std::sqrt(1.0 + x * x) - 1.0;
    }
    sum /= static_cast<double>(measured.size());
    return (std::isfinite(sum) ? sum : wrong) + beyondBounds(names, at);
  };
  fit.material = start;
  if (isFitted(names, "yield_stress")) accesses.at("yield_stress").set(fit.material, yield_stress);
  if (!std::isfinite(fit.material.relaxation_time) && isFitted(names, "relaxation_time"))
    fit.material.relaxation_time = 1.0;
  const auto logarithmsOf = [&](const Material& m) {
    Point at;
    for (const std::string& name : names) {
      const Access& access = accesses.at(name);
      at.push_back(std::log(std::clamp(access.get(m), access.low, access.high)));
    }
    return at;
  };
  Point best = logarithmsOf(fit.material);
  double minimum = std::numeric_limits<double>::infinity();
  if (isFitted(names, "stiffness")) {
    for (const double ratio : {10.0, 50.0, 250.0}) {  // shear modulus over yield stress
      Material tried = fit.material;
      accesses.at("stiffness").set(tried, ratio * yield_stress);
      const Point at = logarithmsOf(tried);
      const double value = loss(at);
      if (value >= minimum) continue;
      minimum = value;
      best = at;
    }
  }
  // A simplex may shrink too early because the forces are noisy; a second one starts where it ended.
  for (const double edge : edges) best = nelderMead(loss, best, edge, done, maximum / 2).at;
  fit.model = run(best);
  const std::vector<double> left = difference(fit.model, measured);
  fit.error = rootMeanSquare(left) / scale;

  const std::vector<double> errors = standardErrors(run, best, left, scale);
  const Material before = fit.material;
  fit.material = withValues(before, names, best);
  for (std::size_t k = 0; k < names.size(); ++k)
    fit.parameters.push_back({names[k], accesses.at(names[k]).get(fit.material), errors[k]});
  return fit;
}

double guessedYieldStress(const PressSetup& setup, const PressCurve& curve) {
  const auto maximum =
      std::max_element(curve.begin(), curve.end(),
                       [](const PressSample& a, const PressSample& b) { return a.force < b.force; });
  const double factor = setup.tool == PressSetup::Tool::plate ? std::sqrt(3.0) : 6.0;
  const double area = std::max(setup.area(maximum->depth), 1e-3 * setup.area(setup.radius));
  return maximum->force / (factor * area);
}

std::string materialFile(const MaterialFit& fit, const std::vector<std::string>& comments) {
  const Material& m = fit.material;
  std::string text;
  for (const std::string& line : comments) text += "# " + line + "\n";
  for (const FitParameter& p : fit.parameters) {
    char line[160];
    if (p.determined())
      std::snprintf(line, sizeof line, "# fitted: %s %s, within a factor of %.2f\n", p.name.c_str(),
                    number(p.value).c_str(), std::exp(p.error));
    else
      std::snprintf(line, sizeof line, "# not determined by the curve: %s %s\n", p.name.c_str(),
                    number(p.value).c_str());
    text += line;
  }
  text += "# the other values are those of material '" + m.name +
          "'; bulk_modulus is at least ten times the stiffness\n";
  for (const clay::Coefficient& c : clay::coefficients)
    text += std::string(c.name) + ": " + number(m.*c.value) + "\n";
  return text;
}

}  // namespace tactile_clay::tools
