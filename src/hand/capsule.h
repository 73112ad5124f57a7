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
/// outward normal n, where n . axis = taper on the cone, less on the sphere at u = 0 and more on the one at u
/// = 1.
struct Capsule {
  Eigen::Vector3d from, to;  // m
  double radius_from, radius_to;

  double length() const { return (to - from).norm(); }
  /// (radius_from - radius_to) / length; one sphere holds the other where its magnitude is one or more.
  double taper() const;
  Eigen::Vector3d centre(double u) const { return from + u * (to - from); }
  double radius(double u) const { return radius_from + u * (radius_to - radius_from); }

  /// Signed distance to the surface, m, negative inside.
  double distance(const Eigen::Vector3d& point) const;
  /// A ball that holds it, about the middle of its axis.
  Ball ball() const { return {0.5 * (from + to), 0.5 * length() + std::max(radius_from, radius_to)}; }
  /// False where the distance is more than that, m: the point is outside of the ball that is as much wider
  /// than the one about the capsule. Cheaper than the distance.
  bool mayBeWithin(double distance, const Eigen::Vector3d& point) const;
};

/// Signed distance to the surface of all of them together, m, negative inside; exact outside. Infinite where
/// there are none.
double distanceToUnion(const std::vector<Capsule>& capsules, const Eigen::Vector3d& point);

}  // namespace tactile_clay::hand
