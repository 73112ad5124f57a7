#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/focal_point.h"

namespace tactile_clay::ultrasound {

/// Where a field is strongest near a focus, in its plane of equal z: uphill from `point` in steps from 1.6 to
/// 0.2 mm.
/// @param amplitude of the field at a point (m)
/// @return m; 8 mm aside at most, where no peak is nearer
Eigen::Vector3d peakNear(const Eigen::Vector3d& point,
                         const std::function<double(const Eigen::Vector3d&)>& amplitude);

/// How many of the points have a peak of the drive's field within `radius` (m) in their plane of equal z:
/// somewhere inside the field is stronger than all around. Looks at 33 places a point, by pressuresAt.
/// @throws std::invalid_argument if the drive's length is not the layout's
std::size_t peaksWithin(double radius, const ArrayLayout& layout, const Acoustics& acoustics,
                        const Drive& drive, const std::vector<FocalPoint>& points);

}  // namespace tactile_clay::ultrasound
