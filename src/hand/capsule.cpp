#include "hand/capsule.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactile_clay::hand {
namespace {

/// @param l m, length
double taperOf(const Capsule& c, double l) {
  if (l > 0.0) return (c.radius_from - c.radius_to) / l;
  return c.radius_from >= c.radius_to ? 1.0 : -1.0;
}

}  // namespace

double Capsule::taper() const {
  return taperOf(*this, length());
}

double Capsule::distance(const Eigen::Vector3d& point) const {
  const double l = length(), k = taperOf(*this, l);
  if (k >= 1.0) return (point - from).norm() - radius_from;
  if (k <= -1.0) return (point - to).norm() - radius_to;
  const Eigen::Vector3d axis = (to - from) / l;
  const double along = (point - from).dot(axis);
  const double across = (point - from - along * axis).norm();
  // The normal through the point leaves the axis where along - across * tan(taper angle) says.
  const double u = std::clamp((along - across * k / std::sqrt(1.0 - k * k)) / l, 0.0, 1.0);
  return (point - centre(u)).norm() - radius(u);
}

bool Capsule::mayBeWithin(double distance, const Eigen::Vector3d& point) const {
  const Ball around = ball();
  return (point - around.middle).norm() <= around.radius + distance;
}

double distanceToUnion(const std::vector<Capsule>& capsules, const Eigen::Vector3d& point) {
  double closest = std::numeric_limits<double>::infinity();
  for (const Capsule& capsule : capsules) closest = std::min(closest, capsule.distance(point));
  return closest;
}

}  // namespace tactile_clay::hand
