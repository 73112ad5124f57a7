#pragma once

#include <ros/package.h>

#include <stdexcept>
#include <string>

namespace tactile_clay::nodes {

/// Folder of this package, which holds `config`. \throws std::runtime_error where ROS does not know it
inline std::string packageFolder() {
  const std::string package = ros::package::getPath("tactile_clay");
  if (package.empty())
    throw std::runtime_error("package tactile_clay is not in ROS_PACKAGE_PATH: source its setup.bash");
  return package;
}

/// Folder of any package, for `package://` in scenes and robot models; empty where ROS does not know it.
inline std::string folderOfPackage(const std::string& package) {
  return ros::package::getPath(package);
}

}  // namespace tactile_clay::nodes
