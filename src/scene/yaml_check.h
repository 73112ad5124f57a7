#pragma once

#include <string>

namespace tactile_clay::scene {

/// Tags that a number may have where an angle is expected.
constexpr char tag_degrees[] = "!degrees", tag_radians[] = "!radians";

/// Whether a tag is one of the core schema, which changes nothing: a plain value has this type anyway. "?"
/// and "!" mean no tag, for plain and for quoted text.
bool isPlainTag(const std::string& tag);

/// The place of a line, "file:line: ".
/// @param line from 0, as YAML marks count
std::string yamlPlace(const std::string& file, int line);

/// Checks a text before it is built: it has one document, its tags are known, and its aliases do not
/// multiply.
/// @param file its name, for error messages
/// @throws std::runtime_error with one line: file, line, what was expected; YAML::Exception if it is not YAML
void checkYaml(const std::string& text, const std::string& file);

}  // namespace tactile_clay::scene
