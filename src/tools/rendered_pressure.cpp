#include "tools/rendered_pressure.h"

#include <chrono>
#include <complex>

#include "tools/shape_error.h"
#include "ultrasound/acoustic_field.h"
#include "ultrasound/field_solver.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::tools {
namespace {

using ultrasound::Modulation;

ultrasound::FocalPointConfig configOf(const Rendering& rendering) {
  ultrasound::FocalPointConfig config;
  config.perceptual_weights = false;  // each place counts by its area
  config.modulation = rendering.field ? Modulation::field : Modulation::amplitude;
  if (!rendering.field) config.max_points = static_cast<std::size_t>(rendering.count);
  return config;
}

}  // namespace

std::string nameOf(const Rendering& rendering) {
  return (rendering.field ? "field:" : "points:") + std::to_string(rendering.count);
}

PressureMeter::PressureMeter(const Rendering& rendering, const std::string& layout,
                             const Eigen::Isometry3d& array)
    : rendering_(rendering),
      layout_(ultrasound::arrayLayouts(layout)),
      to_array_(array.inverse().cast<float>()),
      centre_(array.translation().cast<float>()),
      renderer_(configOf(rendering)) {
  renderer_.setArray(ultrasound::ArrayReach(layout_, air_));
}

void PressureMeter::add(const Skin& skin, const std::vector<SkinForce>& contacts) {
  auto pressed = contact::pressureField(skin, contacts, centre_);
  if (pressed.empty()) return;
  auto all = pressed;
  const auto bare = contact::skinAround(skin, pressed, centre_, skin_around_contacts);
  all.insert(all.end(), bare.begin(), bare.end());
  for (auto* samples : {&pressed, &all})
    for (contact::PressureSample& sample : *samples) {
      sample.position = to_array_ * sample.position;
      sample.normal = to_array_.linear() * sample.normal;
    }
  std::vector<Eigen::Vector3f> places;
  for (const contact::PressureSample& sample : all) places.push_back(sample.position);

  const auto start = std::chrono::steady_clock::now();
  const auto points = renderer_.render(rendering_.field ? all : pressed);
  if (points.empty()) return;
  std::vector<ultrasound::Drive> drives;
  if (rendering_.field) {
    ultrasound::FieldSolverOptions options;
    options.patterns = rendering_.count;
    drives = ultrasound::solveField(layout_, air_, points, options).drives;
  } else {
    drives.push_back(ultrasound::solvePhases(layout_, air_, points).drive);
  }
  sum_.ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  std::vector<double> had(all.size(), 0.0);  // radiation pressure, without a unit: the scale is free
  for (const ultrasound::Drive& drive : drives) {
    const auto at = ultrasound::pressuresAt(layout_, air_, drive, places);
    for (std::size_t i = 0; i < had.size(); ++i) had[i] += static_cast<double>(std::norm(at[i]));
  }
  ShapeError error;
  for (std::size_t i = 0; i < had.size(); ++i) error.add(all[i].area, all[i].pressure, had[i]);
  sum_.error += error.value();
  ++frames_;
}

RenderedPressure PressureMeter::mean() const {
  if (frames_ == 0) return {};
  return {sum_.error / frames_, sum_.ms / frames_};
}

}  // namespace tactile_clay::tools
