#pragma once

#include <ros/node_handle.h>

#include <Eigen/Core>

#include "device/array_device.h"
#include "ultrasound/acoustic_field.h"
#include "ultrasound/array_layout.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::nodes {

/// The physical model of an array: its transducers, the air, the head of a person beside it.
struct ArrayModel {
  /// Reads `~layout`, `~temperature`, `~reference_pressure`, `~solver_iterations`, `~head_point` (in world),
  /// `~array_pose`. \throws std::runtime_error, std::invalid_argument with one line where a parameter is
  /// wrong
  explicit ArrayModel(const ros::NodeHandle& private_nh);

  ultrasound::Drive solve(const device::Emission& emission) const;

  /// dB SPL of a drive at the head.
  double headSpl(const ultrasound::Drive& drive) const;

  /// Highest peak pressure of a drive at one of the points, Pa.
  double focusPressure(const ultrasound::Drive& drive, const device::Emission& emission) const;

  ultrasound::ArrayLayout layout;
  ultrasound::Acoustics acoustics;
  ultrasound::PhaseSolverOptions options;
  Eigen::Vector3d head_point;  // m, frame of the array
};

}  // namespace tactile_clay::nodes
