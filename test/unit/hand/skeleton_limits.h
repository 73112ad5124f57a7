#pragma once

#include <Eigen/Core>

#include "hand/skeleton.h"

namespace tactile_clay::hand {

/// Whether each angle of a pose is within its range.
inline bool withinLimits(const SkeletonPose& pose) {
  for (int k = 0; k < skeleton_joint_count; ++k) {
    const Eigen::Vector2d limit = skeletonLimits(k);
    if (!(pose.angles[k] >= limit[0] && pose.angles[k] <= limit[1])) return false;
  }
  return true;
}

}  // namespace tactile_clay::hand
