#include "ultrasound/field_solver.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "ultrasound/field_objective.h"
#include "ultrasound/turns.h"
#include "values/range.h"

namespace tactile_clay::ultrasound {
namespace {

constexpr std::size_t memory = 6;    // pairs of L-BFGS; more gain nothing in 40 evaluations
constexpr int trial = 2;             // evaluations from each of two starts, to compare them
constexpr double first_turn = 0.03;  // turns, root mean square over the transducers
// Minimum decrease of a step over the decrease that the slope predicts (Nocedal & Wright).
constexpr double armijo = 1e-4;

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("field solver: " + what);
}

void checkTargets(const ArrayLayout& layout, const std::vector<FocalPoint>& targets,
                  const FieldSolverOptions& options, const std::vector<Drive>& before) {
  options.validate();
  for (const FocalPoint& target : targets) {
    const std::string name = " of target " + std::to_string(target.id);
    require(target.position.allFinite(), "position" + name + " is not finite");
    require(target.normal.allFinite(), "normal" + name + " is not finite");
    values::requireIn("field solver: intensity" + name, target.intensity, 0.0, 1.0);
    values::requireAtLeast("field solver: weight" + name, target.weight, 0.0);
  }
  for (const Drive& drive : before)
    require(
        drive.phase.size() == layout.size() && drive.amplitude.size() == layout.size() &&
            std::all_of(drive.phase.begin(), drive.phase.end(), [](float x) { return std::abs(x) < 1e4f; }),
        "a drive before has " + std::to_string(drive.phase.size()) + " phases, expected " +
            std::to_string(layout.size()) + ", each within 10000 rad");
}

TACTILE_CLAY_MULTIVERSION float dot(const Turns& a, const Turns& b) {
  Lanes total{};
  for (std::size_t i = 0; i < a.size(); ++i) total += a[i] * b[i];
  return sum(total);
}

TACTILE_CLAY_MULTIVERSION void addScaled(const Turns& a, float factor, Turns& to) {
  for (std::size_t i = 0; i < a.size(); ++i) to[i] += factor * a[i];
}

TACTILE_CLAY_MULTIVERSION void scale(float factor, Turns& a) {
  for (Lanes& lane : a) lane *= factor;
}

TACTILE_CLAY_MULTIVERSION void roundTurns(float levels, Turns& turns) {
  for (Lanes& lane : turns) lane = nearest(lane * levels) / levels;
}

/// Limits the change from `before` to `turns`, by the shorter way round, to `maximum`.
TACTILE_CLAY_MULTIVERSION void limitChange(const Turns& before, float maximum, Turns& turns) {
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const Lanes way = turns[i] - before[i];
    const Lanes shorter = way - nearest(way);
    turns[i] = before[i] + min(max(shorter, Lanes{} - maximum), Lanes{} + maximum);
  }
}

struct Pair {
  Turns step, change;  // changes of the phases and of the gradient
  float inverse;       // 1 over their product
};

/// -H^-1 gradient, by the two loops of L-BFGS.
Turns newtonStep(const Turns& gradient, const std::vector<Pair>& pairs) {
  Turns step = gradient;
  std::vector<float> along(pairs.size());
  for (std::size_t k = pairs.size(); k-- > 0;) {
    along[k] = pairs[k].inverse * dot(pairs[k].step, step);
    addScaled(pairs[k].change, -along[k], step);
  }
  if (!pairs.empty()) {
    const Pair& last = pairs.back();
    scale(1.0f / (last.inverse * dot(last.change, last.change)), step);
  }
  for (std::size_t k = 0; k < pairs.size(); ++k)
    addScaled(pairs[k].step, along[k] - pairs[k].inverse * dot(pairs[k].change, step), step);
  scale(-1.0f, step);
  return step;
}

/// Lowers the objective with at most this number of evaluations.
/// @return its value at `turns`
double descend(FieldObjective& objective, int evaluations, Turns& turns) {
  Turns gradient(turns.size()), next(turns.size()), next_gradient(turns.size());
  std::vector<Pair> pairs;
  double value = objective(turns, &gradient);
  for (int used = 1; used < evaluations;) {
    Turns step = newtonStep(gradient, pairs);
    double slope = dot(gradient, step);
    if (!(slope < 0.0) && !pairs.empty()) {  // rounding: start over
      pairs.clear();
      step = newtonStep(gradient, pairs);
      slope = dot(gradient, step);
    }
    if (!(slope < 0.0)) break;  // a minimum
    const auto numbers = static_cast<double>(turns.size() * wide_lane_count);
    double length = pairs.empty() ? first_turn / std::sqrt(dot(step, step) / numbers) : 1.0;
    for (bool lower = false; !lower && used < evaluations; ++used) {
      next = turns;
      addScaled(step, static_cast<float>(length), next);
      const double next_value = objective(next, &next_gradient);
      lower = next_value <= value + armijo * length * slope;
      if (!lower) {  // to the minimum of the parabola
        const double bend = next_value - value - length * slope;
        length *= std::clamp(-length * slope / (2.0 * bend), 0.1, 0.6);
        continue;
      }
      Pair pair{next, next_gradient, 0.0f};
      addScaled(turns, -1.0f, pair.step);
      addScaled(gradient, -1.0f, pair.change);
      const float product = dot(pair.step, pair.change);
      constexpr float minimum = 1e-12f;  // a smaller bend is lost in rounding
      if (product > minimum) {
        pair.inverse = 1.0f / product;
        if (pairs.size() == memory) pairs.erase(pairs.begin());
        pairs.push_back(std::move(pair));
      }
      std::swap(turns, next);
      std::swap(gradient, next_gradient);
      value = next_value;
    }
  }
  return value;
}

Turns turnsOf(const std::vector<Drive>& drives, std::size_t width) {
  Turns turns(drives.size() * width, Lanes{});
  for (std::size_t k = 0; k < drives.size(); ++k)
    for (std::size_t n = 0; n < drives[k].phase.size(); ++n)
      turns[k * width + n / wide_lane_count][n % wide_lane_count] = drives[k].phase[n] * over_turn;
  return turns;
}

/// The amplitude of all transducers with which the pressure is not higher than wanted.
float amplitudeOfAll(const FieldSolverOptions& options, double scale) {
  const double share = std::min(1.0, std::sqrt(1.0 / scale));
  const double amplitude = options.amplitude * share;
  if (options.amplitude_levels == 0) return static_cast<float>(amplitude);
  constexpr double rounding = 1e-4;  // of a level: an amplitude that is a level already stays there
  const double maximum = std::floor(options.amplitude * options.amplitude_levels + rounding);
  return static_cast<float>(std::min(std::ceil(amplitude * options.amplitude_levels - rounding), maximum) /
                            options.amplitude_levels);
}

void setDrives(const Turns& turns, std::size_t width, float amplitude, std::vector<Drive>& drives) {
  for (std::size_t k = 0; k < drives.size(); ++k) {
    for (std::size_t n = 0; n < drives[k].phase.size(); ++n) {
      const float t = turns[k * width + n / wide_lane_count][n % wide_lane_count];
      drives[k].phase[n] = two_pi * (t - std::floor(t));
      drives[k].amplitude[n] = amplitude;
    }
  }
}

std::vector<Eigen::Vector3f> positionsOf(const std::vector<FocalPoint>& targets) {
  std::vector<Eigen::Vector3f> at;
  for (const FocalPoint& target : targets) at.push_back(target.position.cast<float>());
  return at;
}

/// Sets `reached` from the field of the drives.
void setReached(const ArrayLayout& layout, const Acoustics& acoustics, const std::vector<FocalPoint>& targets,
                FieldSolution& solution) {
  const auto reached = meanAmplitudesAt(layout, acoustics, solution.drives, positionsOf(targets));
  solution.reached.assign(reached.begin(), reached.end());
}

/// Sets `error` and `scale` from `wanted` and `on_skin`.
void setFit(FieldSolution& solution) {
  const FieldFit fit = fieldFit(solution.wanted, solution.on_skin);
  solution.error = fit.error;
  solution.scale = fit.scale;
}

}  // namespace

void FieldSolverOptions::validate() const {
  values::requireAtLeast("field solver: strength", strength, 0.0);
  require(patterns == 1 || patterns == 2 || patterns == 4 || patterns == 8,
          "patterns is " + std::to_string(patterns) + ", expected 1, 2, 4 or 8");
  values::requireIn("field solver: evaluations", evaluations, 1, 10000);
  values::requireAbove("field solver: amplitude", amplitude, 0.0);
  values::requireIn("field solver: amplitude", amplitude, 0.0, 1.0);
  if (phase_levels != 0) values::requireIn("field solver: phase_levels, if not 0", phase_levels, 2, 65536);
  values::requireIn("field solver: amplitude_levels", amplitude_levels, 0, 65536);
  values::requireAtLeast("field solver: max_phase_change (rad)", max_phase_change, 0.0);
  values::requireIn("field solver: blur (m)", blur, 0.0, 0.1);
}

FieldSolution solveField(const ArrayLayout& layout, const Acoustics& acoustics,
                         const std::vector<FocalPoint>& targets, const FieldSolverOptions& options,
                         const std::vector<Drive>& before) {
  checkTargets(layout, targets, options, before);
  FieldObjective objective(layout, acoustics, targets, options);
  FieldSolution solution;
  solution.reach = objective.reach();
  for (std::size_t m = 0; m < targets.size(); ++m)
    solution.wanted.push_back(targets[m].intensity * solution.reach[m]);
  solution.reached.assign(targets.size(), 0.0);
  solution.on_skin = solution.reached;
  const auto patterns = static_cast<std::size_t>(options.patterns);
  solution.drives.assign(patterns,
                         {std::vector<float>(layout.size(), 0.0f), std::vector<float>(layout.size(), 0.0f)});
  if (objective.silent()) {
    setFit(solution);
    return solution;
  }

  const bool follows = before.size() == patterns;
  const bool limited = follows && options.max_phase_change > 0.0;
  Turns last;
  if (follows) last = turnsOf(before, objective.width());
  Turns turns = limited ? last : objective.start();
  int left = options.evaluations;
  if (follows && !limited) {
    Turns going_on = last;
    const double anew = descend(objective, trial, turns);
    if (descend(objective, trial, going_on) <= anew) turns = std::move(going_on);
    left -= 2 * trial;
  }
  descend(objective, left, turns);
  if (limited)
    limitChange(last, static_cast<float>(std::min(options.max_phase_change, M_PI)) * over_turn, turns);
  if (options.phase_levels > 0) roundTurns(static_cast<float>(options.phase_levels), turns);

  objective(turns, nullptr);
  solution.error = objective.error();
  const float amplitude = amplitudeOfAll(options, objective.scale());
  const double share = amplitude / options.amplitude;
  solution.scale = share * share * objective.scale();
  for (std::size_t m = 0; m < targets.size(); ++m) solution.on_skin[m] = share * objective.amplitude(m);
  if (!objective.plain()) setFit(solution);
  setDrives(turns, objective.width(), amplitude, solution.drives);
  solution.reached = solution.on_skin;
  if (knowSkin(targets)) setReached(layout, acoustics, targets, solution);
  return solution;
}

FieldFit fieldFit(const std::vector<double>& wanted, const std::vector<double>& given) {
  double both = 0.0;
  double had = 0.0;
  double square = 0.0;
  for (std::size_t m = 0; m < wanted.size(); ++m) {
    const double w = std::pow(wanted[m], 2);
    const double g = std::pow(given[m], 2);
    both += w * g;
    had += g * g;
    square += w * w;
  }
  if (!(square > 0.0)) return {};
  if (!(had > 0.0)) return {1.0, 0.0};
  return {std::sqrt(std::max(0.0, 1.0 - both * both / (had * square))), both / square};
}

bool knowSkin(const std::vector<FocalPoint>& targets) {
  return std::any_of(targets.begin(), targets.end(), [](const auto& t) { return !t.normal.isZero(0.0); });
}

std::vector<float> amplitudesOnSkin(const ArrayLayout& layout, const Acoustics& acoustics,
                                    const std::vector<Drive>& drives,
                                    const std::vector<FocalPoint>& targets) {
  std::vector<Eigen::Vector3f> normals;
  for (const FocalPoint& target : targets) normals.push_back(target.normal.normalized().cast<float>());
  return meanAmplitudesAt(layout, acoustics, drives, positionsOf(targets), normals);
}

void judgeField(const ArrayLayout& layout, const Acoustics& acoustics, const std::vector<FocalPoint>& targets,
                FieldSolution& solution) {
  setReached(layout, acoustics, targets, solution);
  solution.on_skin = solution.reached;
  if (knowSkin(targets)) {
    const auto on_skin = amplitudesOnSkin(layout, acoustics, solution.drives, targets);
    solution.on_skin.assign(on_skin.begin(), on_skin.end());
  }
  setFit(solution);
}

}  // namespace tactile_clay::ultrasound
