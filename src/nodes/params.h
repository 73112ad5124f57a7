#pragma once

#include <ros/node_handle.h>

#include <Eigen/Geometry>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>

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

/// \throws std::runtime_error with one line unless a number is within [low, high]. \param name with what it
/// is, "parameter /node/key"
template <typename T>
void requireIn(const std::string& name, const T& value, const T& low, const T& high) {
  if (value >= low && value <= high) return;
  std::ostringstream line;
  line << name << ": expected a number from " << low << " to " << high << ", got " << value;
  throw std::runtime_error(line.str());
}

/// Parameter `key`, or `fallback` where it is not set.
/// \throws std::runtime_error with one line if it is set to another type; integers are taken for real numbers
template <typename T>
T param(const ros::NodeHandle& nh, const std::string& key, const T& fallback) {
  T value = fallback;
  if (nh.hasParam(key) && !nh.getParam(key, value))
    throw std::runtime_error("parameter " + nh.resolveName(key) + ": expected " + kindOfParam<T>());
  return value;
}

/// As `param`, within [low, high]. \throws std::runtime_error naming the parameter, its value and its range
template <typename T>
T paramIn(const ros::NodeHandle& nh, const std::string& key, const T& fallback, const T& low, const T& high) {
  const T value = param(nh, key, fallback);
  requireIn("parameter " + nh.resolveName(key), value, low, high);
  return value;
}

/// Pose "x y z roll pitch yaw" (m, rad; R = Rz(yaw) Ry(pitch) Rx(roll)), a text or a list.
/// \throws std::runtime_error naming the parameter
Eigen::Isometry3d poseParam(const ros::NodeHandle& nh, const std::string& key, const std::string& fallback);

/// Point "x y z" (m), a text or a list. \throws std::runtime_error naming the parameter
Eigen::Vector3d pointParam(const ros::NodeHandle& nh, const std::string& key, const std::string& fallback);

}  // namespace tactile_clay::nodes
