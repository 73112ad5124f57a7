#pragma once

#include <Eigen/Geometry>

namespace tactile_clay::values {

/// Rotation matrix of three angles, rad: R = Rz(yaw) Ry(pitch) Rx(roll).
inline Eigen::Matrix3d turnOf(double roll, double pitch, double yaw) {
  return (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

/// Pose from the six numbers x y z roll pitch yaw: m, and angles in rad as in turnOf.
/// @param n at least six numbers, as a vector or an array of doubles; `numbersOf` reads them from a text
template <typename Numbers>
Eigen::Isometry3d poseOf(const Numbers& n) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << n[0], n[1], n[2];
  pose.linear() = turnOf(n[3], n[4], n[5]);
  return pose;
}

}  // namespace tactile_clay::values
