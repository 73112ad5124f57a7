#include "ultrasound/skin_disc.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactile_clay::ultrasound {
namespace {

// m: over a finger tip (radius 5 mm) a disc of this radius rises 0.9 mm above the skin at its rim.
constexpr double flat = 3e-3;

}  // namespace

double SkinDisc::distance(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d way = point - centre;
  const double height = way.dot(normal);
  const double beside = std::max(0.0, (way - height * normal).norm() - radius);
  return std::hypot(height, beside);
}

SkinDisc skinDisc(const contact::PressureSample& sample) {
  const Eigen::Vector3d centre = sample.position.cast<double>();
  const Eigen::Vector3d normal = sample.normal.cast<double>().stableNormalized();
  // A normal of length 0, or with numbers that are not finite, could not be normalised.
  if (!(std::abs(normal.squaredNorm() - 1.0) < 0.5)) return {centre, Eigen::Vector3d::Zero(), 0.0};
  return {centre, normal, std::min(flat, std::sqrt(sample.area / M_PI))};
}

Eigen::Vector3d ontoSkin(const Eigen::Vector3d& point, const std::vector<SkinDisc>& skin) {
  double closest = std::numeric_limits<double>::infinity();
  const SkinDisc* disc = nullptr;
  for (const SkinDisc& candidate : skin) {
    const double distance = candidate.distance(point);
    if (distance < closest) {
      closest = distance;
      disc = &candidate;
    }
  }
  const Eigen::Vector3d way = point - disc->centre;
  const double length = way.norm();
  if (closest <= skin_tolerance && length <= farthest_from_sample) return point;
  // A disc is convex: on the way to its centre the distance falls at least in proportion.
  const double left = std::clamp(2.0 - closest / skin_tolerance, 0.0, 1.0);
  return disc->centre + std::min(left, farthest_from_sample / length) * way;
}

}  // namespace tactile_clay::ultrasound
