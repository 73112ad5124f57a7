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
/// 1.6 mm, where the normal beside a bent knuckle is that of both phalanges.
inline constexpr double skin_tolerance = 1.4e-3;

/// The farthest place from a sample, m. The signed distance to the skin changes by no more than one goes
/// (Lipschitz constant 1), so a place this close to a sample is no farther from the skin than that, whatever
/// shape the skin has: where two fingers pinch, the disc of one reaches into the other. 3 mm are promised.
inline constexpr double farthest_from_sample = 2.9e-3;

/// `point` where it is on the skin. Farther off it is led to the closest disc's centre, without a leap: at
/// twice the tolerance it is there. No place is farther than `farthest_from_sample` from that centre.
/// @param skin at least one disc; the first of equally close ones counts
Eigen::Vector3d ontoSkin(const Eigen::Vector3d& point, const std::vector<SkinDisc>& skin);

}  // namespace tactile_clay::ultrasound
