#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/focal_point.h"

namespace tactile_clay::ultrasound {

/// Place near a focus, in its plane of equal z, at which a field is strongest. The search goes uphill from
/// `point`, in steps from 1.6 to 0.2 mm.
/// @param amplitude of the field at a point (m)
/// @return m; at most 8 mm from `point`
Eigen::Vector3d peakNear(const Eigen::Vector3d& point,
                         const std::function<double(const Eigen::Vector3d&)>& amplitude);

/// How many of the points have a peak of the drive's field within `radius` (m) in their plane of equal z: a
/// place inside the circle at which the field is stronger than everywhere on the circle. Computes the field
/// at 33 places per point, by pressuresAt.
/// @throws std::invalid_argument if the drive's length is not the layout's
std::size_t peaksWithin(double radius, const ArrayLayout& layout, const Acoustics& acoustics,
                        const Drive& drive, const std::vector<FocalPoint>& points);

}  // namespace tactile_clay::ultrasound
