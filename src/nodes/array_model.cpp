#include "nodes/array_model.h"

#include "nodes/params.h"

namespace tactile_clay::nodes {

ArrayModel::ArrayModel(const ros::NodeHandle& private_nh)
    : layout(ultrasound::arrayLayouts(param<std::string>(private_nh, "layout", "usx"))) {
  acoustics.temperature = paramIn(private_nh, "temperature", acoustics.temperature, -20.0, 60.0);
  acoustics.reference_pressure =
      paramIn(private_nh, "reference_pressure", acoustics.reference_pressure, 0.01, 100.0);
  acoustics.validate();
  options.iterations = paramIn(private_nh, "solver_iterations", options.iterations, 1, 1000);
  options.method = ultrasound::phaseMethod(param<std::string>(private_nh, "phase_method", "newton"));
  options.phase_only = param(private_nh, "phase_only", options.phase_only);
  options.peaks = param(private_nh, "peaks", options.peaks);
  options.phase_levels = paramIn(private_nh, "phase_levels", options.phase_levels, 0, 65536);
  options.amplitude_levels = paramIn(private_nh, "amplitude_levels", options.amplitude_levels, 0, 65536);
  options.max_phase_change = paramIn(private_nh, "max_phase_change", options.max_phase_change, 0.0, 3.2);
  field_options.strength = paramIn(private_nh, "field_strength", field_options.strength, 0.0, 10.0);
  field_options.patterns = paramIn(private_nh, "field_patterns", field_options.patterns, 1, 8);
  field_options.evaluations = paramIn(private_nh, "field_evaluations", field_options.evaluations, 1, 10000);
  field_options.phase_levels = options.phase_levels;
  field_options.amplitude_levels = options.amplitude_levels;
  field_options.max_phase_change = options.max_phase_change;
  field_options.validate();
  const Eigen::Isometry3d array = poseParam(private_nh, "array_pose", "0 0 -0.15 0 0 0");
  head_point = array.inverse() * pointParam(private_nh, "head_point", "-0.4 0 0.45");
}

ultrasound::PhaseSolution ArrayModel::solve(const std::vector<ultrasound::FocalPoint>& points,
                                            const ultrasound::Drive* before) const {
  return ultrasound::solvePhases(layout, acoustics, points, options,
                                 options.max_phase_change > 0.0 ? before : nullptr);
}

ultrasound::FieldSolution ArrayModel::solveField(const std::vector<ultrasound::FocalPoint>& targets,
                                                 double amplitude,
                                                 const std::vector<ultrasound::Drive>& before) const {
  ultrasound::FieldSolverOptions most = field_options;
  most.amplitude = amplitude;
  return ultrasound::solveField(layout, acoustics, targets, most, before);
}

}  // namespace tactile_clay::nodes
