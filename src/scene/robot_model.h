#pragma once

#include <filesystem>
#include <string>

namespace tactile_clay::scene {

/// Text of a robot model (URDF) as all its readers take it: urdfdom, robot_state_publisher and rviz. Macros
/// are expanded by the program `xacro`, and any encoding that XML declares is read.
/// @throws std::runtime_error with one line that names the file
std::string loadRobotModel(const std::string& file);

/// The same for a text in UTF-8 without macros; what is ready is left as it is.
///
/// - The root link of the result is `world`; another root hangs on it by a fixed joint, at its origin.
/// - Floating and planar joints are fixed: nothing in the rig moves them, and so tf has all links.
/// - A capsule is a cylinder and two spheres: urdfdom knows no capsules.
/// - Files of meshes and textures are addresses (`file://`, `package://`), not relative to the model's
/// folder.
///
/// @param folder of the model, which relative names of files start from
/// @throws std::runtime_error with one line, where it is no XML of bounded size and depth, or its links are
/// no tree
std::string readyModel(const std::string& xml, const std::filesystem::path& folder);

}  // namespace tactile_clay::scene
