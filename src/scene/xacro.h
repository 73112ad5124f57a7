#pragma once

#include <string>

namespace tactile_clay::scene {

/// Whether a robot model is written with macros of xacro: by its name, or by what stands in it. Models that
/// xacro made still name its namespace, and have none.
bool hasMacros(const std::string& xml, const std::string& file);

/// What the program `xacro` of ROS makes of a file, with the defaults of its arguments.
/// @throws std::runtime_error with one line where there is no such program, it fails, or it takes longer than
/// 20 s
std::string expandMacros(const std::string& file);

}  // namespace tactile_clay::scene
