#include "tools/modulation_way.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>
#include <utility>

#include "device/instrument.h"
#include "tools/shape_error.h"
#include "ultrasound/felt_force.h"
#include "ultrasound/modulation.h"

namespace tactile_clay::tools {
namespace {

using ultrasound::Modulation;

constexpr int levels = 32;  // of phases

double frequencyOf(Modulation modulation, const std::vector<ultrasound::FocalPoint>& points) {
  switch (modulation) {
    case Modulation::lateral:
      return 10.0;
    case Modulation::circle:
    case Modulation::field_circle:
      return 5.0;
    case Modulation::spatiotemporal:
      return ultrasound::spatiotemporalFrequency(points);
    default:
      return 200.0;
  }
}

device::Instrument instrumentOf(const Array& array, const ultrasound::FieldSolverOptions& options) {
  device::Instrument instrument;
  instrument.solve = [&array](const auto& points, const auto*) {
    ultrasound::PhaseSolverOptions phases;
    phases.phase_levels = levels;
    return ultrasound::solvePhases(array.layout, array.air, points, phases);
  };
  instrument.loudness = [](const auto&, const auto&) { return device::Loudness(); };
  instrument.solve_field = [&array, options](const auto& targets, double, const auto& before, double effort) {
    ultrasound::FieldSolverOptions now = options;
    now.evaluations = std::max(1, static_cast<int>(std::lround(effort * options.evaluations)));
    return ultrasound::solveField(array.layout, array.air, targets, now, before);
  };
  return instrument;
}

/// The sound that the array plays for these points, without a safety gate.
device::Sound soundOf(const Array& array, const std::vector<ultrasound::FocalPoint>& points,
                      ModulationWay& way) {
  const Modulation modulation = way.config.modulation;
  device::Sound sound{{points, frequencyOf(modulation, points), modulation}, {}};
  const device::Instrument instrument = instrumentOf(array, way.options);
  if (!ultrasound::isField(modulation)) {
    device::solveParts(instrument, {}, sound);
    return sound;
  }
  std::optional<ultrasound::FieldSolution> field;
  const auto start = std::chrono::steady_clock::now();
  device::solvePatterns(instrument, 1.0, way.before, sound, field);
  way.cost.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  way.before.clear();
  for (const device::Sound::Part& part : sound.parts) way.before.push_back(part.drive);
  return sound;
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) /
         std::max(1.0, static_cast<double>(values.size()));
}

/// Mean of the known values, or a dash if there are none.
std::string known(const std::vector<double>& values, double unit, const char* format) {
  char text[40] = "-";
  if (!values.empty()) std::snprintf(text, sizeof text, format, unit * mean(values));
  return text;
}

}  // namespace

ModulationWay pointsWay(const std::string& name, Modulation modulation) {
  ultrasound::FocalPointConfig config;
  config.modulation = modulation;
  ModulationWay way;
  way.name = name;
  way.config = config;
  way.renderer.configure(config);
  return way;
}

ModulationWay fieldWay(const std::string& name, const ultrasound::FieldSolverOptions& options,
                       const ultrasound::FocalPointConfig& config) {
  ModulationWay way = pointsWay(name, config.modulation);
  way.config = config;
  way.renderer.configure(config);
  way.options = options;
  way.options.phase_levels = levels;
  return way;
}

void renderFrame(const Array& array, const Samples& pressed, const Samples& all, const RefinedSkin* skin,
                 ModulationWay& way) {
  const auto points = way.renderer.render(ultrasound::isField(way.config.modulation) ? all : pressed);
  if (points.empty()) {
    way.before.clear();
    return;
  }
  if (skin == nullptr && !ultrasound::isField(way.config.modulation)) return;
  const device::Sound sound = soundOf(array, points, way);
  if (skin == nullptr) return;
  std::vector<double> square(skin->position.size(), 0.0);  // mean of squared amplitudes
  double on = 0.0;                                         // mean of the modulation of pressure
  float amplitude = 0.0f;
  for (const device::Sound::Part& part : sound.parts) {
    amplitude =
        std::max(amplitude, *std::max_element(part.drive.amplitude.begin(), part.drive.amplitude.end()));
    on += part.what.power;
    const auto at =
        array.on_skin
            ? ultrasound::pressuresAt(array.layout, array.air, part.drive, skin->position, skin->normal)
            : ultrasound::pressuresAt(array.layout, array.air, part.drive, skin->position);
    for (std::size_t i = 0; i < at.size(); ++i)
      square[i] += part.what.power * static_cast<double>(std::norm(at[i]));
  }
  std::vector<float> had;
  for (const double s : square)
    had.push_back(static_cast<float>(ultrasound::radiationPressure(array.air, std::sqrt(s))));
  const float peak = *std::max_element(had.begin(), had.end());
  double contact = 0.0, covered = 0.0, felt = 0.0, force = 0.0;
  for (std::size_t i = 0; i < had.size(); ++i) {
    const double f = skin->pressure[i] * skin->area[i];
    contact += f;
    felt += f * had[i];
    force += had[i] * skin->area[i] / on;
    if (had[i] >= 0.25f * peak) covered += f;
  }
  way.points.push_back(static_cast<double>(points.size()));
  way.coverage.push_back(covered / contact);
  way.error.push_back(shapeError(*skin, had, false));
  way.weighted.push_back(shapeError(*skin, had, true));
  way.pressure.push_back(felt / contact);
  way.maximum.push_back(felt / contact / std::pow(static_cast<double>(amplitude), 2));
  way.force.push_back(force);
  const ultrasound::FeltForce sense =
      ultrasound::feltForce(way.config.modulation, sound.emission.modulation_frequency, force);
  if (sense.vibration > 0.0) way.vibration.push_back(sense.vibration);
  if (sense.pressure > 0.0) way.touch.push_back(sense.pressure);
}

void startAnew(ModulationWay& way) {
  way.renderer.reset();
  way.before.clear();
}

void printTable(std::vector<ModulationWay>& ways) {
  std::printf(
      "| modulation | points | error %% | weighted error %% | pressure, Pa | at full drive, Pa | coverage %% "
      "| force, mN | above threshold, dB | felt as steady, mN | solver, ms: median, 90 %% |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (ModulationWay& way : ways) {
    std::printf("| %s | %.1f | %.1f | %.1f | ", way.name.c_str(), mean(way.points), 100 * mean(way.error),
                100 * mean(way.weighted));
    std::printf("%.2f | %.2f | %.0f | ", mean(way.pressure), mean(way.maximum), 100 * mean(way.coverage));
    std::printf("%.2f | %s | %s | ", 1e3 * mean(way.force), known(way.vibration, 1.0, "%.0f").c_str(),
                known(way.touch, 1e3, "%.0f").c_str());
    if (way.cost.empty()) {
      std::printf("|\n");
      continue;
    }
    std::sort(way.cost.begin(), way.cost.end());
    const auto at = [&](double share) {
      return 1e3 * way.cost[static_cast<std::size_t>(share * static_cast<double>(way.cost.size() - 1))];
    };
    std::printf("%.2f, %.2f |\n", at(0.5), at(0.9));
  }
  std::printf("\n");
}

}  // namespace tactile_clay::tools
