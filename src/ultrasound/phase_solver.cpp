#include "ultrasound/phase_solver.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "ultrasound/focus_solver.h"
#include "ultrasound/phase_rounding.h"
#include "ultrasound/propagator.h"
#include "ultrasound/turns.h"
#include "values/range.h"

namespace tactile_clay::ultrasound {
namespace {

constexpr double min_intensity = 1e-3;  // weaker foci are not noticed among the others
constexpr double resolvable = 1.5;      // separation below which two foci cannot both be peaks

const std::map<std::string, PhaseMethod>& methods() {
  static const std::map<std::string, PhaseMethod> known = {
      {"naive", PhaseMethod::naive},
      {"weighted_gerchberg_saxton", PhaseMethod::weighted_gerchberg_saxton},
      {"gs_pat", PhaseMethod::gs_pat},
      {"newton", PhaseMethod::newton}};
  return known;
}

void checkPoints(const ArrayLayout& layout, const std::vector<FocalPoint>& points,
                 const PhaseSolverOptions& options, const Drive* before) {
  values::requireIn("phase solver: iterations", options.iterations, 1, 1000);
  if (options.phase_levels != 0)
    values::requireIn("phase solver: phase_levels, if not 0", options.phase_levels, 2, 65536);
  values::requireIn("phase solver: amplitude_levels", options.amplitude_levels, 0, 65536);
  values::requireAtLeast("phase solver: max_phase_change (rad)", options.max_phase_change, 0.0);
  for (const FocalPoint& point : points) {
    if (!point.position.allFinite()) {
      throw std::invalid_argument("phase solver: position of focal point " + std::to_string(point.id) +
                                  " is not finite");
    }
    values::requireIn("phase solver: intensity of focal point " + std::to_string(point.id), point.intensity,
                      0.0, 1.0);
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

/// A drive in lanes.
DriveLanes driveLanes(const Drive& drive, std::size_t width) {
  LaneArray<Lanes> turns(width, Lanes{});
  LaneArray<Lanes> amplitude(width, Lanes{});
  for (std::size_t n = 0; n < drive.phase.size(); ++n) {
    turns[n / wide_lane_count][n % wide_lane_count] = drive.phase[n] * over_turn;
    amplitude[n / wide_lane_count][n % wide_lane_count] = drive.amplitude[n];
  }
  DriveLanes q(width);
  for (std::size_t i = 0; i < width; ++i) {
    unitCircle(turns[i], q[i].re, q[i].im);
    q[i].re *= amplitude[i];
    q[i].im *= amplitude[i];
  }
  return q;
}

PhaseLimit phaseLimit(const Drive& before, double maximum, std::size_t width) {
  PhaseLimit limit{LaneArray<Lanes>(width, Lanes{}), LaneArray<Lanes>(width, Lanes{} + 1.0f)};
  for (std::size_t n = 0; n < before.phase.size(); ++n) {
    limit.before[n / wide_lane_count][n % wide_lane_count] = before.phase[n] * over_turn;
    if (before.amplitude[n] > 0.0f) {
      limit.change[n / wide_lane_count][n % wide_lane_count] =
          static_cast<float>(std::min(maximum, 2.0 * M_PI)) * over_turn;
    }
  }
  return limit;
}

TACTILE_CLAY_INLINE Lanes amplitudeOf(const ComplexLanes& a) {
  const Lanes squared = a.re * a.re + a.im * a.im;
  return squared * inverseRoot(max(squared, Lanes{} + 1e-30f));
}

/// Lowers the drive until the weakest focus has just its target.
void lower(const FocusField& p, DriveLanes& q) {
  const float factor = std::min(1.0f / std::max(p.abs().minCoeff(), tiny_amplitude), 1.0f);
  for (ComplexLanes& a : q) {
    a.re *= factor;
    a.im *= factor;
  }
}

/// Rounds amplitudes to the levels of the device: a common amplitude up, so that no focus falls below its
/// target; others to the nearest level.
TACTILE_CLAY_MULTIVERSION void roundAmplitudes(int levels, bool up, DriveLanes& q) {
  const auto steps = static_cast<float>(levels);
  for (ComplexLanes& a : q) {
    const Lanes amplitude = amplitudeOf(a);
    const Lanes at = amplitude * steps + (up ? 0.5f - 1e-4f : 0.0f);
    const Lanes rounded = min(nearest(at), Lanes{} + steps) / steps;
    const Lanes factor = rounded / max(amplitude, Lanes{} + 1e-10f);
    a.re *= factor;
    a.im *= factor;
  }
}

/// Sets the phase of each drive to its level.
TACTILE_CLAY_MULTIVERSION void setPhases(const LaneArray<Lanes>& level, int levels, DriveLanes& q) {
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Lanes amplitude = amplitudeOf(q[i]);
    unitCircle(level[i] * (1.0f / static_cast<float>(levels)), q[i].re, q[i].im);
    q[i].re *= amplitude;
    q[i].im *= amplitude;
  }
}

/// @param level of the phases if they were rounded, otherwise null
Drive driveOf(const DriveLanes& q, std::size_t transducers, const LaneArray<Lanes>* level, int levels) {
  Drive drive{std::vector<float>(transducers), std::vector<float>(transducers)};
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Lanes turns = turnsOf(q[i].re, q[i].im);
    const Lanes amplitude = min(amplitudeOf(q[i]), Lanes{} + 1.0f);
    const Lanes positive = turns < 0.0f ? turns + 1.0f : turns;
    const Lanes phase =
        level == nullptr ? two_pi * positive : (*level)[i] * two_pi / static_cast<float>(levels);
    const std::size_t first = i * wide_lane_count;
    for (std::size_t n = first; n < std::min(first + wide_lane_count, transducers); ++n) {
      drive.phase[n] = phase[n - first];
      drive.amplitude[n] = amplitude[n - first];
    }
  }
  return drive;
}

/// The points that take part. Each has a row of the propagator, divided by its target: so every focus has to
/// reach 1.
struct Foci {
  std::vector<std::size_t> active;  // indices of the points
  std::vector<FocusBeam> beams;
  Propagator g;
};

/// Also sets the targets of a solution.
Foci fociOf(const ArrayLayout& layout, const Acoustics& acoustics, const std::vector<FocalPoint>& points,
            PhaseSolution& solution) {
  const TransducerLanes transducers(layout);
  Foci foci{{}, {}, Propagator(points.size(), transducers.x.size())};
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (points[k].intensity < min_intensity) continue;
    const FocusBeam beam = foci.g.addFocus(transducers, acoustics, points[k].position);
    if (!(beam.reach > 0.0f)) continue;
    solution.target[k] = points[k].intensity * beam.reach;  // divided by sqrt(M) below
    foci.active.push_back(k);
    foci.beams.push_back(beam);
  }
  const double sharing = std::sqrt(static_cast<double>(foci.active.size()));
  for (std::size_t m = 0; m < foci.active.size(); ++m) {
    double& target = solution.target[foci.active[m]];
    target /= sharing;
    foci.g.scaleRow(m, static_cast<float>(1.0 / target));
  }
  return foci;
}

/// The foci, with those marked that can be peaks; empty if peaks are not asked for or there is one focus.
std::vector<FocusShape> shapesOf(const Foci& foci, const std::vector<FocalPoint>& points, double wavenumber,
                                 bool peaks) {
  const std::vector<std::size_t>& active = foci.active;
  std::vector<FocusShape> shapes;
  for (std::size_t m = 0; peaks && active.size() > 1 && m < active.size(); ++m) {
    FocusShape shape{true, 0.5f * foci.beams[m].spread.topLeftCorner<2, 2>().trace()};
    for (std::size_t n = 0; n < active.size(); ++n) {
      const Eigen::Vector3d way = points[active[n]].position - points[active[m]].position;
      if (n != m && separation(way, foci.beams[m], foci.beams[n], wavenumber) < resolvable)
        shape.peak = false;
    }
    shapes.push_back(shape);
  }
  return shapes;
}

/// Lowers and rounds the drive that a solver has found.
/// @param limit of the phases; null: no limit
Drive deviceDrive(const PhaseSolverOptions& options, std::size_t transducers, const PhaseLimit* limit,
                  FocusSolver& solver) {
  DriveLanes& q = solver.q();
  const bool own_amplitudes = !options.phase_only && options.amplitude_levels > 0;
  if (own_amplitudes) {
    lower(solver.p(), q);
    roundAmplitudes(options.amplitude_levels, false, q);
  }
  LaneArray<Lanes> level;
  if (options.phase_levels > 0) {
    level = roundPhases(solver.g(), q, options.phase_levels, limit);
    setPhases(level, options.phase_levels, q);
  }
  if (!own_amplitudes) {
    lower(solver.p(), q);
    if (options.amplitude_levels > 0) roundAmplitudes(options.amplitude_levels, true, q);
  }
  return driveOf(q, transducers, level.empty() ? nullptr : &level, options.phase_levels);
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
  checkPoints(layout, points, options, before);
  PhaseSolution solution;
  solution.target.assign(points.size(), 0.0);
  solution.reached.assign(points.size(), 0.0);
  solution.drive.phase.assign(layout.size(), 0.0f);
  solution.drive.amplitude.assign(layout.size(), 0.0f);

  Foci foci = fociOf(layout, acoustics, points, solution);
  const std::vector<std::size_t>& active = foci.active;
  if (active.empty()) return solution;
  Eigen::ArrayXf power(static_cast<Eigen::Index>(active.size()));
  for (std::size_t m = 0; m < active.size(); ++m)
    power(static_cast<Eigen::Index>(m)) = static_cast<float>(std::pow(points[active[m]].intensity, 2));

  const double k = acoustics.wavenumber();
  FocusSolver solver(std::move(foci.g), layout.size(), k, shapesOf(foci, points, k, options.peaks), options);
  DriveLanes last;
  if (before != nullptr) {
    last = driveLanes(*before, solver.g().width);
    solver.start(last);
  }
  solver.solve(power);
  PhaseLimit limit;
  const bool limited = before != nullptr && options.max_phase_change > 0.0;
  if (limited) {
    limit = phaseLimit(*before, options.max_phase_change, solver.g().width);
    solver.limit(limit, last);
  }
  solution.drive = deviceDrive(options, layout.size(), limited ? &limit : nullptr, solver);
  const Eigen::ArrayXf share = solver.p().abs();
  for (std::size_t m = 0; m < active.size(); ++m) {
    solution.reached[active[m]] = share(static_cast<Eigen::Index>(m)) * solution.target[active[m]];
  }
  return solution;
}

}  // namespace tactile_clay::ultrasound
