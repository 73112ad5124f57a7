#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "clay/mesh.h"

namespace tactile_clay::scene {

/// Reads a closed mesh: STL (text or binary), DAE or OBJ. The unit of length and the poses of nodes in a DAE
/// are applied. Its up axis is ignored, as in rviz.
/// @param scale of each axis; a negative one mirrors
/// @throws std::runtime_error with one line that names the file, if it cannot be read, is too large, or is
///   not closed
std::shared_ptr<const clay::Mesh> loadMesh(const std::string& file, const Eigen::Vector3d& scale);

}  // namespace tactile_clay::scene
