#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

namespace tactile_clay::hand {

struct Ball {
  Eigen::Vector3d middle;
  double radius;  // m
};

/// Tapered capsule: the hull of two spheres. Each point of its surface is centre(u) + radius(u) n with the
/// outward normal n. On the cone n . axis = taper; it is more on the sphere at u = 1, and less on the one at
/// u = 0.
struct Capsule {
  Eigen::Vector3d from, to;  // m
  double radius_from, radius_to;

  double length() const { return (to - from).norm(); }
  /// (radius_from - radius_to) / length. If its magnitude is 1 or more, one sphere contains the other.
  double taper() const;
  Eigen::Vector3d centre(double u) const { return from + u * (to - from); }
  double radius(double u) const { return radius_from + u * (radius_to - radius_from); }

  /// Signed distance to the surface, m, negative inside.
  double distance(const Eigen::Vector3d& point) const;
  /// A ball that contains the capsule, about the middle of its axis.
  Ball ball() const { return {0.5 * (from + to), 0.5 * length() + std::max(radius_from, radius_to)}; }
  /// False if the point is more than `distance`, m, outside the ball about the capsule. It is then also
  /// farther than that from the capsule. Cheaper than the distance.
  bool mayBeWithin(double distance, const Eigen::Vector3d& point) const;
};

/// Signed distance to the surface of the union of the capsules, m, negative inside; exact outside. Infinite
/// if there are no capsules.
double distanceToUnion(const std::vector<Capsule>& capsules, const Eigen::Vector3d& point);

}  // namespace tactile_clay::hand
