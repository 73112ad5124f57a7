#pragma once

#include <ros/node_handle.h>

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "device/instrument.h"
#include "device/safety_limits.h"
#include "nodes/settings.h"
#include "ultrasound/acoustic_field.h"
#include "ultrasound/array_layout.h"
#include "ultrasound/field_solver.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::nodes {

/// `~temperature` and `~reference_pressure`.
/// @throws std::runtime_error, std::invalid_argument with one line where one is wrong
ultrasound::Acoustics acousticsOf(Settings& settings);

/// The physical model of an array: its transducers, the air, the head of a person beside it.
struct ArrayModel {
  /// Reads `~layout`, `~temperature`, `~reference_pressure`, `~head_point` (in world), `~array_pose`, and of
  /// the phase solver `~phase_method`, `~solver_iterations`, `~peaks` (default true), `~phase_only`,
  /// `~phase_levels`, `~amplitude_levels`, `~max_phase_change`, and of the field solver `~field_strength`,
  /// `~field_patterns`, `~field_evaluations`, `~field_blur`.
  /// @throws std::runtime_error, std::invalid_argument with one line where a parameter is wrong
  explicit ArrayModel(const ros::NodeHandle& private_nh);
  ArrayModel() = default;

  /// All but the poses.
  /// @throws as above
  void read(Settings& settings);

  /// Its phase solver.
  /// @param before as of solvePhases
  ultrasound::PhaseSolution solve(const std::vector<ultrasound::FocalPoint>& points,
                                  const ultrasound::Drive* before) const;

  /// The patterns of a field.
  /// @param amplitude, before as of solveField
  /// @param effort share of the evaluations
  ultrasound::FieldSolution solveField(const std::vector<ultrasound::FocalPoint>& targets, double amplitude,
                                       const std::vector<ultrasound::Drive>& before, double effort) const;

  /// `field_options` with this maximum amplitude, and this share of the evaluations.
  ultrasound::FieldSolverOptions fieldOptions(double amplitude, double effort) const;

  ultrasound::ArrayLayout layout;
  ultrasound::Acoustics acoustics;
  ultrasound::PhaseSolverOptions options;
  ultrasound::FieldSolverOptions field_options;
  Eigen::Vector3d head_point = Eigen::Vector3d::Zero();  // m, frame of the array
};

/// How loud a drive of the array is that was made for these points, to a gate with these limits.
/// @throws std::invalid_argument as device::LoudnessMeter
std::function<device::Loudness(const ultrasound::Drive& drive,
                               const std::vector<ultrasound::FocalPoint>& points)>
loudnessOf(const ArrayModel& model, const device::SafetyGateConfig& config);

}  // namespace tactile_clay::nodes
