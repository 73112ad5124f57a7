#include "device/sonic_surface_drives.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "device/options.h"
#include "ultrasound/array_reach.h"
#include "ultrasound/focus_peak.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::device::sonic_surface {
namespace {

constexpr unsigned patterns = 64;      // of channels that are on, to choose from
constexpr double near_focus = 0.0019;  // m, in which a focus has its peak
constexpr int fewest = 4;              // channels that make a focus; three or two make fringes, one a wave

ultrasound::PhaseSolverOptions solverOptions(Firmware firmware) {
  ultrasound::PhaseSolverOptions options;
  options.phase_levels = firmware == Firmware::stock ? 32 : 16;
  return options;
}

/// The transducers that sound, and which of the layout each of them is.
std::pair<ultrasound::ArrayLayout, std::vector<std::size_t>> channelsThatAreOn(
    const ultrasound::ArrayLayout& layout, const ultrasound::Drive& drive) {
  std::pair<ultrasound::ArrayLayout, std::vector<std::size_t>> on;
  for (std::size_t n = 0; n < layout.size(); ++n) {
    if (drive.amplitude[n] == 0.0f) continue;
    on.first.position.push_back(layout.position[n]);
    on.first.normal.push_back(layout.normal[n]);
    on.second.push_back(n);
  }
  return on;
}

/// Phases of the channels that are on, for without the others the foci would be neither as strong nor where
/// they were.
/// @param target amplitude of each point, Pa
void solveAnew(const Playable& array, std::vector<ultrasound::FocalPoint> points,
               const std::vector<double>& target, ultrasound::Drive& drive) {
  const auto [on, channel] = channelsThatAreOn(array.layout, drive);
  double strongest = 0.0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    points[k].intensity = target[k] / ultrasound::focusPressure(on, array.acoustics, points[k].position);
    strongest = std::max(strongest, points[k].intensity);
  }
  for (ultrasound::FocalPoint& point : points) point.intensity /= strongest;  // all that the channels give
  const ultrasound::Drive part =
      ultrasound::solvePhases(on, array.acoustics, points, solverOptions(array.firmware)).drive;
  for (std::size_t n = 0; n < channel.size(); ++n) drive.phase[channel[n]] = part.phase[n];
}

/// Drive for points that are there at once, before it is made what the boards can emit.
ultrasound::Drive solve(const Playable& array, const std::vector<ultrasound::FocalPoint>& points) {
  const auto whole =
      ultrasound::solvePhases(array.layout, array.acoustics, points, solverOptions(array.firmware));
  std::vector<ultrasound::FocalPoint> sounding;
  std::vector<double> target;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!(whole.target[k] > 0.0)) continue;
    sounding.push_back(points[k]);
    target.push_back(whole.target[k]);
  }
  ultrasound::Drive best;
  std::size_t maximum = 0;
  for (unsigned pattern = 0; pattern < patterns; ++pattern) {
    ultrasound::Drive drive = emitted(whole.drive, array.firmware, pattern, array.added);
    const auto on = std::count(drive.amplitude.begin(), drive.amplitude.end(), 1.0f);
    if (on < fewest) {
      std::fill(drive.amplitude.begin(), drive.amplitude.end(), 0.0f);
      return drive;
    }
    if (on == static_cast<std::ptrdiff_t>(array.layout.size())) return drive;
    solveAnew(array, sounding, target, drive);
    const std::size_t peaks =
        ultrasound::peaksWithin(near_focus, array.layout, array.acoustics, drive, sounding);
    if (pattern > 0 && peaks <= maximum) continue;
    maximum = peaks;
    best = std::move(drive);
    if (maximum == sounding.size()) break;
  }
  return best;
}

/// Phases of the channels that are on, for the same field as strong as they can give it.
/// @param wanted amplitude at each target, Pa
void solveAnew(const Playable& array, std::vector<ultrasound::FocalPoint> targets,
               const std::vector<double>& wanted, ultrasound::FieldSolverOptions options,
               ultrasound::Drive& drive) {
  const auto [on, channel] = channelsThatAreOn(array.layout, drive);
  ultrasound::Drive before{{}, std::vector<float>(channel.size(), 1.0f)};
  for (const std::size_t n : channel) before.phase.push_back(drive.phase[n]);
  const ultrasound::ArrayReach reach(on, array.acoustics);
  double strongest = 1.0;
  for (std::size_t k = 0; k < targets.size(); ++k) {
    const double maximum = reach.amplitude(targets[k].position);
    targets[k].intensity = maximum > 0.0 ? wanted[k] / maximum : 0.0;
    strongest = std::max(strongest, targets[k].intensity);
  }
  for (ultrasound::FocalPoint& target : targets) target.intensity /= strongest;
  options.amplitude = 1.0;
  const ultrasound::Drive part =
      ultrasound::solveField(on, array.acoustics, targets, options, {before}).drives.front();
  for (std::size_t n = 0; n < channel.size(); ++n) drive.phase[channel[n]] = part.phase[n];
}

}  // namespace

Boards boardsOf(const std::map<std::string, std::string>& options) {
  Boards boards;
  if (choice(options, "sonic_surface", "firmware", "stock", {"stock", "tactile"}) == "tactile")
    boards.firmware = Firmware::tactile;
  boards.count = choice(options, "sonic_surface", "boards", "1", {"1", "2"}) == "2" ? 2 : 1;
  if (boards.count == 2 && boards.firmware == Firmware::tactile)
    throw std::runtime_error("sonic_surface: boards is '2', expected 1 with the tactile firmware");
  boards.first =
      choice(options, "sonic_surface", "board", "primary", {"primary", "secondary"}) == "primary" ? 0 : 1;
  if (boards.first == 1 && (boards.count == 2 || boards.firmware == Firmware::tactile))
    throw std::runtime_error(
        "sonic_surface: board is 'secondary', expected one board with the stock firmware");
  return boards;
}

ultrasound::ArrayLayout layoutOf(std::size_t boards, const Eigen::Isometry3d& second) {
  std::string csv = "channel,column,row\n";
  const auto order = channelOrder();
  for (std::size_t n = 0; n < order.size(); ++n)
    csv += std::to_string(n) + "," + std::to_string(order[n].first) + "," + std::to_string(order[n].second) +
           "\n";
  ultrasound::ArrayLayout layout = ultrasound::arrayLayout("sonic_surface", csv);
  for (std::size_t n = 0; boards == 2 && n < order.size(); ++n) {
    layout.position.push_back(second * layout.position[n]);
    layout.normal.push_back(second.linear() * layout.normal[n]);
  }
  return layout;
}

ultrasound::Drive Playable::drive(const std::vector<ultrasound::FocalPoint>& points) const {
  return emitted(solve(*this, points), firmware, 0, added);
}

ultrasound::FieldSolution Playable::field(const std::vector<ultrasound::FocalPoint>& targets,
                                          const ultrasound::FieldSolverOptions& options,
                                          const std::vector<ultrasound::Drive>& before) const {
  ultrasound::FieldSolverOptions own = options;
  own.patterns = 1;  // the wire is too slow for more
  own.phase_levels = solverOptions(firmware).phase_levels;
  own.amplitude_levels = 0;
  ultrasound::FieldSolution solution = ultrasound::solveField(layout, acoustics, targets, own, before);
  ultrasound::Drive& drive = solution.drives.front();
  ultrasound::Drive heard = emitted(drive, firmware, 0, added);
  const auto on = std::count(heard.amplitude.begin(), heard.amplitude.end(), 1.0f);
  if (on < fewest) {
    std::fill(heard.amplitude.begin(), heard.amplitude.end(), 0.0f);
  } else if (on < static_cast<std::ptrdiff_t>(layout.size())) {
    solveAnew(*this, targets, solution.wanted, own, heard);
    heard = emitted(heard, firmware, 0, added);
  }
  drive = std::move(heard);
  ultrasound::judgeField(layout, acoustics, targets, solution);
  return solution;
}

}  // namespace tactile_clay::device::sonic_surface
