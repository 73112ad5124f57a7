#pragma once

#include <filesystem>
#include <string>

namespace tactile_clay::scene {

/// Text of a robot model (URDF) that all its readers accept: urdfdom, robot_state_publisher and rviz. Macros
/// are expanded by the program `xacro`, and any encoding that XML declares is read.
/// @throws std::runtime_error with one line that names the file
std::string loadRobotModel(const std::string& file);

/// The same for a text in UTF-8 without macros. A text that is ready is left as it is.
///
/// - The root link of the result is `world`. Another root is joined to it by a fixed joint, at its origin.
/// - Floating and planar joints become fixed joints: nothing in the rig moves them. So tf has all links.
/// - A capsule becomes a cylinder and two spheres: urdfdom has no capsules.
/// - Names of mesh and texture files become addresses (`file://`, `package://`): they are not relative to the
///   folder of the model.
///
/// @param folder of the model, from which relative names of files start
/// @throws std::runtime_error with one line, if it is not XML of bounded size and depth, or its links are not
///   a tree
std::string readyModel(const std::string& xml, const std::filesystem::path& folder);

}  // namespace tactile_clay::scene
