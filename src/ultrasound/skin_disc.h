#pragma once

#include <Eigen/Core>
#include <vector>

#include "contact/pressure_field.h"

namespace tactile_clay::ultrasound {

/// What is known of the skin at a sample: a flat disc of its area, but no wider than skin is flat. If the
/// normal is not known, it is a point.
struct SkinDisc {
  Eigen::Vector3d centre;  // m
  Eigen::Vector3d normal;  // unit; zero for a point
  double radius;           // m

  /// Distance of a place from the disc, m.
  double distance(const Eigen::Vector3d& point) const;
};

SkinDisc skinDisc(const contact::PressureSample& sample);

/// A point counts as on the skin up to this distance from the discs, m. A disc leaves the skin of a finger by
/// up to 1.6 mm: beside a bent knuckle its normal is that of both phalanges.
inline constexpr double skin_tolerance = 1.4e-3;

/// Maximum distance of a focal point from its sample, m. A sample lies on the skin, so a point at the
/// distance d from it is at most d from the skin, whatever shape the skin has. This matters if two fingers
/// pinch: the disc of one reaches into the other. The documents promise 3 mm.
inline constexpr double farthest_from_sample = 2.9e-3;

/// Returns `point` if it is on the skin. If it is farther off, it is moved towards the centre of the closest
/// disc. How far it is moved grows continuously with the distance; from twice the tolerance on the result is
/// the centre. No result is farther than `farthest_from_sample` from that centre.
/// @param skin at least one disc; the first of equally close ones counts
Eigen::Vector3d ontoSkin(const Eigen::Vector3d& point, const std::vector<SkinDisc>& skin);

}  // namespace tactile_clay::ultrasound
