#pragma once

#include <Eigen/Core>
#include <vector>

#include "device/instrument.h"
#include "device/safety_limits.h"
#include "ultrasound/field_maximum.h"

namespace tactile_clay::device {

/// How loud drives of an array are: the highest pressure anywhere in the gate's workspace, wherever the
/// points are that a drive was made for, and the level at the head.
class LoudnessMeter {
 public:
  /// @param head_point m, frame of the array
  /// @param config its workspace and its cap: pressures below that are those at the points
  /// @throws std::invalid_argument as FieldMaximum
  LoudnessMeter(const ultrasound::ArrayLayout& layout, const ultrasound::Acoustics& acoustics,
                const Eigen::Vector3d& head_point, const SafetyGateConfig& config);

  /// @throws std::invalid_argument if the drive's length is not the layout's
  Loudness operator()(const ultrasound::Drive& drive,
                      const std::vector<ultrasound::FocalPoint>& points) const;

 private:
  ultrasound::ArrayLayout layout_;
  ultrasound::Acoustics acoustics_;
  Eigen::Vector3d head_point_;
  ultrasound::FieldMaximum maximum_;
};

}  // namespace tactile_clay::device
