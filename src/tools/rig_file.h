#pragma once

#include <string>

namespace tactile_clay::tools {

/// Checks a file of rig:=, a map of parameters that stand for those of config/rig.yaml and of the nodes, with
/// the functions by which the nodes read them. Arguments of the rig are given there, and not in the file.
/// \throws std::runtime_error with one line: file, line, what was expected
void requireRigFile(const std::string& file);

}  // namespace tactile_clay::tools
