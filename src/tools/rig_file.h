#pragma once

#include <map>
#include <string>

namespace tactile_clay::tools {

/// Checks a file of rig:=, a map of parameters that stand for those of config/rig.yaml and of the nodes, with the
/// functions by which the nodes read them.
/// \param arguments of the rig, each of which is given there and not in the file
/// \throws std::runtime_error with one line: file, line, what was expected
void requireRigFile(const std::string& file, const std::map<std::string, std::string>& arguments);

}  // namespace tactile_clay::tools
