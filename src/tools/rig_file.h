#pragma once

#include <map>
#include <string>

#include "scene/scene.h"

namespace tactile_clay::tools {

/// Checks a file of rig:=, a map of parameters that stand for those of config/rig.yaml and of the nodes, with
/// the functions by which the nodes read them. Arguments of the rig are given there, and not in the file.
/// @throws std::runtime_error with one line: file, line, what was expected
void requireRigFile(const std::string& file);

/// Checks a file of person:=, a map of what the renderer knows of a person, as `staircase` writes it.
/// @throws std::runtime_error with one line: file, line, what was expected
void requirePersonFile(const std::string& file);

/// Checks parameters NODE/NAME of the rig's nodes, with the functions by which the nodes read them.
/// @param parameters texts by name, as YAML has them
/// @param scene that is kneaded
/// @throws std::runtime_error with one line naming the parameter and what was expected
void requireParameters(const std::map<std::string, std::string>& parameters, const scene::Scene& scene);

}  // namespace tactile_clay::tools
