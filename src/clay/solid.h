#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace tactile_clay::clay {

class Mesh;

/// A rigid collider with an exact signed distance. The clay collides with it without skin samples.
struct Solid {
  enum class Shape { box, cylinder, sphere, mesh };

  std::string name;
  Shape shape = Shape::box;
  /// m; box: half extents; cylinder: radius, half length (z); sphere: radius
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  std::shared_ptr<const Mesh> mesh;                        // only for Shape::mesh; contains the size
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // of the shape in world
  // For solids that move from there with constant velocity, see `poseAfter`.
  Eigen::Vector3d linear_velocity = Eigen::Vector3d::Zero();   // m/s, of the shape's origin
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // rad/s, world axes
};

/// How solids move: sets `poses` to their poses in world at time t (s), one per solid in the same order.
/// Equal times give equal bits.
using SolidMotion = std::function<void(double t, std::vector<Eigen::Isometry3d>& poses)>;

struct SurfacePoint {
  double distance;         // m, negative inside
  Eigen::Vector3d normal;  // outward, unit
};

/// Signed distance of a point to the shape and the direction out of it, in the shape's own coordinate frame.
/// At an exact medial point, such as the centre of a sphere, one of the equally short ways out is taken.
SurfacePoint surface(const Solid& solid, const Eigen::Vector3d& point);

/// The smallest box that contains the shape, in the shape's own coordinate frame.
Eigen::AlignedBox3d boundsOf(const Solid& solid);

/// Pose after `t` seconds with the solid's velocities, which stay constant.
Eigen::Isometry3d poseAfter(const Solid& solid, double t);

}  // namespace tactile_clay::clay
