#include "nodes/array_model.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "device/loudness_meter.h"
#include "nodes/params.h"

namespace tactile_clay::nodes {

ultrasound::Acoustics acousticsOf(Settings& s) {
  ultrasound::Acoustics acoustics;
  acoustics.temperature =
      s.number("temperature", acoustics.temperature, -20.0, 60.0, "temperature of the air, degrees C");
  acoustics.reference_pressure = s.number("reference_pressure", acoustics.reference_pressure, 0.01, 100.0,
                                          "peak pressure of one transducer at 1 m, Pa");
  acoustics.validate();
  return acoustics;
}

ArrayModel::ArrayModel(const ros::NodeHandle& private_nh) {
  Settings settings(private_nh);
  read(settings);
  const Eigen::Isometry3d array = poseParam(private_nh, "array_pose", "0 0 -0.15 0 0 0");
  head_point = array.inverse() * pointParam(private_nh, "head_point", "-0.4 0 0.45");
}

void ArrayModel::read(Settings& s) {
  layout = ultrasound::arrayLayouts(s.text("layout", "usx", "transducers of the array"));
  acoustics = acousticsOf(s);
  options.iterations =
      s.whole("solver_iterations", options.iterations, 1, 1000, "iterations of the phase solver");
  options.method = ultrasound::phaseMethod(s.text("phase_method", "newton", "the phase solver"));
  options.phase_only = s.truth("phase_only", options.phase_only, "transducers at full amplitude, or silent");
  options.peaks = s.truth("peaks", options.peaks, "each focal point is a peak of the field");
  options.phase_levels =
      s.whole("phase_levels", options.phase_levels, 0, 65536, "steps per turn; 0: any phase");
  options.amplitude_levels = s.whole("amplitude_levels", options.amplitude_levels, 0, 65536,
                                     "steps of the amplitude; 0: any amplitude");
  options.max_phase_change = s.number("max_phase_change", options.max_phase_change, 0.0, 3.2,
                                      "maximum change of a phase per frame, rad; 0: any");
  field_options.strength = s.number("field_strength", field_options.strength, 0.0, 10.0,
                                    "of a field: a larger value is stronger, and less exact");
  field_options.patterns = s.whole("field_patterns", field_options.patterns, 1, ultrasound::max_patterns,
                                   "of a field: patterns that take turns");
  field_options.evaluations = s.whole("field_evaluations", field_options.evaluations, 1, 10000,
                                      "of a field: maximum number of evaluations of its solver");
  field_options.blur =
      s.number("field_blur", field_options.blur, 0.0, 0.1, "of a field: blur by the skin, m; 0: none");
  field_options.phase_levels = options.phase_levels;
  field_options.amplitude_levels = options.amplitude_levels;
  field_options.max_phase_change = options.max_phase_change;
  field_options.validate();
}

ultrasound::PhaseSolution ArrayModel::solve(const std::vector<ultrasound::FocalPoint>& points,
                                            const ultrasound::Drive* before) const {
  return ultrasound::solvePhases(layout, acoustics, points, options,
                                 options.max_phase_change > 0.0 ? before : nullptr);
}

ultrasound::FieldSolution ArrayModel::solveField(const std::vector<ultrasound::FocalPoint>& targets,
                                                 double amplitude,
                                                 const std::vector<ultrasound::Drive>& before,
                                                 double effort) const {
  return ultrasound::solveField(layout, acoustics, targets, fieldOptions(amplitude, effort), before);
}

ultrasound::FieldSolverOptions ArrayModel::fieldOptions(double amplitude, double effort) const {
  ultrasound::FieldSolverOptions own = field_options;
  own.amplitude = amplitude;
  own.evaluations = std::max(1, static_cast<int>(std::lround(effort * own.evaluations)));
  return own;
}

std::function<device::Loudness(const ultrasound::Drive&, const std::vector<ultrasound::FocalPoint>&)>
loudnessOf(const ArrayModel& model, const device::SafetyGateConfig& config) {
  const auto meter =
      std::make_shared<device::LoudnessMeter>(model.layout, model.acoustics, model.head_point, config);
  return [meter](const auto& drive, const auto& points) { return (*meter)(drive, points); };
}

}  // namespace tactile_clay::nodes
