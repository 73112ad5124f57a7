#include "clay/solid.h"

#include <algorithm>

#include "clay/mesh.h"

namespace tactile_clay::clay {
namespace {

SurfacePoint boxSurface(const Eigen::Vector3d& half, const Eigen::Vector3d& p) {
  const Eigen::Vector3d q = p.cwiseAbs() - half;
  const Eigen::Vector3d sign = p.unaryExpr([](double v) { return v < 0.0 ? -1.0 : 1.0; });
  const Eigen::Vector3d outside = q.cwiseMax(0.0);
  const double distance = outside.norm();
  if (distance > 0.0) return {distance, outside.cwiseProduct(sign) / distance};
  int axis = 0;
  q.maxCoeff(&axis);
  return {q[axis], sign[axis] * Eigen::Vector3d::Unit(axis)};
}

SurfacePoint cylinderSurface(double radius, double half_length, const Eigen::Vector3d& p) {
  const double rho = p.head<2>().norm();
  const Eigen::Vector3d radial =
      rho > 0.0 ? Eigen::Vector3d(p.x() / rho, p.y() / rho, 0.0) : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d axial(0.0, 0.0, p.z() < 0.0 ? -1.0 : 1.0);
  const double side = rho - radius, cap = std::abs(p.z()) - half_length;
  if (side > 0.0 && cap > 0.0) {
    const double distance = std::hypot(side, cap);
    return {distance, (side * radial + cap * axial) / distance};
  }
  return side > cap ? SurfacePoint{side, radial} : SurfacePoint{cap, axial};
}

SurfacePoint sphereSurface(double radius, const Eigen::Vector3d& p) {
  const double r = p.norm();
  return {r - radius, r > 0.0 ? Eigen::Vector3d(p / r) : Eigen::Vector3d::UnitZ()};
}

}  // namespace

SurfacePoint surface(const Solid& solid, const Eigen::Vector3d& point) {
  switch (solid.shape) {
    case Solid::Shape::box:
      return boxSurface(solid.size, point);
    case Solid::Shape::cylinder:
      return cylinderSurface(solid.size.x(), solid.size.y(), point);
    case Solid::Shape::mesh:
      return solid.mesh->surface(point);
    case Solid::Shape::sphere:
      break;
  }
  return sphereSurface(solid.size.x(), point);
}

Eigen::AlignedBox3d boundsOf(const Solid& solid) {
  if (solid.shape == Solid::Shape::mesh) return solid.mesh->bounds();
  Eigen::Vector3d half = solid.size;
  if (solid.shape == Solid::Shape::cylinder) half = {solid.size.x(), solid.size.x(), solid.size.y()};
  if (solid.shape == Solid::Shape::sphere) half.setConstant(solid.size.x());
  return {-half, half};
}

Eigen::Isometry3d poseAfter(const Solid& solid, double t) {
  Eigen::Isometry3d pose = solid.pose;
  pose.translation() += t * solid.linear_velocity;
  const double rate = solid.angular_velocity.norm();
  if (rate > 0.0) {
    pose.linear() = Eigen::AngleAxisd(rate * t, solid.angular_velocity / rate) * solid.pose.linear();
  }
  return pose;
}

}  // namespace tactile_clay::clay
