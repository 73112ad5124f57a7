#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "clay/mesh.h"

namespace tactile_clay::scene {

/// Reads a closed mesh: STL (text or binary), DAE or OBJ. A DAE's unit of length counts, and its nodes'
/// places; which axis it says is up does not, as in rviz.
/// @param scale of each axis; a negative one mirrors
/// @throws std::runtime_error with one line that names the file, where it cannot be read, is too large, or is
/// not
///         closed
std::shared_ptr<const clay::Mesh> loadMesh(const std::string& file, const Eigen::Vector3d& scale);

}  // namespace tactile_clay::scene
