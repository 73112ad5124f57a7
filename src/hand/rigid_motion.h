#pragma once

#include <Eigen/Geometry>

namespace tactile_clay::hand {

/// The rotation and translation that bring points nearest to others, by the sum of squared distances (Umeyama
/// 1991).
/// @param from one point a column, at least 3
/// @param to as many
Eigen::Isometry3d rigidMotion(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

}  // namespace tactile_clay::hand
