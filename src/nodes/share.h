#pragma once

#include <ros/package.h>

#include <stdexcept>
#include <string>

namespace tactile_clay::nodes {

/// Folder `config` of this package. \throws std::runtime_error where ROS does not know the package
inline std::string configFolder() {
  const std::string package = ros::package::getPath("tactile_clay");
  if (package.empty()) throw std::runtime_error("package tactile_clay is not in ROS_PACKAGE_PATH: source its setup.bash");
  return package + "/config";
}

}  // namespace tactile_clay::nodes
