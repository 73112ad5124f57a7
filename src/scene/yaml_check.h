#pragma once

#include <string>

namespace tactile_clay::scene {

/// Tags that a number may have where an angle is expected.
constexpr char tag_degrees[] = "!degrees", tag_radians[] = "!radians";

/// Tags of the core schema say what a plain value is anyway. "?" and "!" are none: plain and quoted text.
bool isPlainTag(const std::string& tag);

/// Where a line stands, "file:line: ".
/// @param line from 0, as YAML marks count
std::string yamlPlace(const std::string& file, int line);

/// Looks at a text before it is built: it has one document, its tags are known, and its aliases do not
/// multiply.
/// @param file its name, for lines about it
/// @throws std::runtime_error with one line: file, line, what was expected; YAML::Exception where it is not
/// YAML
void checkYaml(const std::string& text, const std::string& file);

}  // namespace tactile_clay::scene
