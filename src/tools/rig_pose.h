#pragma once

#include <Eigen/Geometry>
#include <string>

#include "scene/yaml_reader.h"
#include "values/pose.h"

namespace tactile_clay::tools {

/// A pose of config/rig.yaml, in the world.
/// @param key such as "array_pose"
/// @param share folder of config/
inline Eigen::Isometry3d rigPose(const std::string& share, const std::string& key) {
  return values::poseOf(scene::loadYaml(share + "/config/rig.yaml").pose(key));
}

}  // namespace tactile_clay::tools
