#pragma once

#include <Eigen/Core>
#include <vector>

#include "contact/pressure_field.h"

namespace tactile_clay::ultrasound {

/// What is known of the skin at a sample: a flat disc of its area, but no wider than skin is flat. Where the
/// normal is not known, it is a point.
struct SkinDisc {
  Eigen::Vector3d centre;  // m
  Eigen::Vector3d normal;  // unit; of a point zero
  double radius;           // m

  /// m
  double distance(const Eigen::Vector3d& point) const;
};

SkinDisc skinDisc(const contact::PressureSample& sample);

/// How far from the discs a point still counts as on the skin, m. A disc leaves the skin of a finger by up to
/// 1.6 mm, where the normal beside a bent knuckle is that of both phalanges: a point this close to one is
/// less than 3 mm off the skin.
inline constexpr double skin_tolerance = 1.4e-3;

/// `point` where it is on the skin. Farther off it is led to the closest disc's centre, without a leap: at
/// twice the tolerance it is there. \param skin at least one disc; the first of equally close ones counts
Eigen::Vector3d ontoSkin(const Eigen::Vector3d& point, const std::vector<SkinDisc>& skin);

}  // namespace tactile_clay::ultrasound
