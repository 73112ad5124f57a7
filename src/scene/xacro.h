#pragma once

#include <string>

namespace tactile_clay::scene {

/// Whether a robot model is written with macros of xacro, by its file name or its contents. Models that xacro
/// has made still name its namespace, but contain no macros.
bool hasMacros(const std::string& xml, const std::string& file);

/// Output of the program `xacro` of ROS for a file, with the default values of its arguments.
/// @throws std::runtime_error with one line if there is no such program, it fails, needs more than 1 GiB of
///   memory, writes more than 16 MiB, or takes longer than 20 s
std::string expandMacros(const std::string& file);

}  // namespace tactile_clay::scene
