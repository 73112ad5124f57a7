#pragma once

#include <ros/package.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

namespace tactile_clay::nodes {

/// Folder of this package, which holds `config`.
/// @throws std::runtime_error where ROS does not know it
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

/// Whether ROS knows a package. Not by its path, for which rospack tells the standard error what it does not
/// find.
inline bool hasPackage(const std::string& package) {
  std::vector<std::string> all;
  ros::package::getAll(all);
  return std::find(all.begin(), all.end(), package) != all.end();
}

}  // namespace tactile_clay::nodes
