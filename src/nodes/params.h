#pragma once

#include <ros/node_handle.h>

#include <Eigen/Geometry>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "values/range.h"

namespace tactile_clay::nodes {

/// What a parameter of type T is, for people.
template <typename T>
constexpr const char* kindOfParam() {
  return std::is_same_v<T, bool>          ? "true or false"
         : std::is_same_v<T, int>         ? "a whole number"
         : std::is_same_v<T, std::string> ? "a text"
         : std::is_same_v<T, double>      ? "a number"
                                          : "a list of texts";
}

/// Parameter `key`, or `fallback` where it is not set.
/// @throws std::runtime_error with one line if it is set to another type; integers are taken for real numbers
template <typename T>
T param(const ros::NodeHandle& nh, const std::string& key, const T& fallback) {
  T value = fallback;
  if (nh.hasParam(key) && !nh.getParam(key, value))
    throw std::runtime_error("parameter " + nh.resolveName(key) + ": expected " + kindOfParam<T>());
  return value;
}

/// As `param`, within [low, high].
/// @throws std::runtime_error naming the parameter, its value and its range
template <typename T>
T paramIn(const ros::NodeHandle& nh, const std::string& key, const T& fallback, const T& low, const T& high) {
  const T value = param(nh, key, fallback);
  values::requireIn<std::runtime_error>("parameter " + nh.resolveName(key), value, low, high);
  return value;
}

/// Pose "x y z roll pitch yaw" (m, rad; R = Rz(yaw) Ry(pitch) Rx(roll)), a text or a list.
/// @throws std::runtime_error naming the parameter
Eigen::Isometry3d poseParam(const ros::NodeHandle& nh, const std::string& key, const std::string& fallback);

/// Point "x y z" (m), a text or a list.
/// @throws std::runtime_error naming the parameter
Eigen::Vector3d pointParam(const ros::NodeHandle& nh, const std::string& key, const std::string& fallback);

}  // namespace tactile_clay::nodes
