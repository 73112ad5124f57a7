#pragma once

#include <Eigen/Core>
#include <memory>

#include "ultrasound/acoustics.h"
#include "ultrasound/array_layout.h"
#include "ultrasound/focus_beam.h"

namespace tactile_clay::ultrasound {

struct TransducerLanes;

/// What an array can give at a point when all of it is focused there, quickly: focusPressure in single
/// precision.
class ArrayReach {
 public:
  ArrayReach(const ArrayLayout& layout, const Acoustics& acoustics);

  /// Peak acoustic pressure, Pa: sum of |G_n|, within 1e-5 of it.
  /// @param point m, frame of the array
  double amplitude(const Eigen::Vector3d& point) const;
  FocusBeam beam(const Eigen::Vector3d& point) const;

  const Acoustics& acoustics() const { return acoustics_; }

 private:
  Acoustics acoustics_;
  std::shared_ptr<const TransducerLanes> transducers_;
};

}  // namespace tactile_clay::ultrasound
