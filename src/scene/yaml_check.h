#pragma once

#include <string>

namespace tactile_clay::scene {

/// Tags that a number may have where an angle is expected.
constexpr char tag_degrees[] = "!degrees", tag_radians[] = "!radians";

/// Whether a tag is one of the core schema, which changes nothing: a plain value has this type anyway. "?"
/// and "!" mean no tag, for plain and for quoted text.
bool isPlainTag(const std::string& tag);

/// Whether a value has neither a tag nor quotes.
bool hasNoTag(const std::string& tag);

/// The place of a line, "file:line: ".
/// @param line from 0, as YAML marks count
std::string yamlPlace(const std::string& file, int line);

/// Who reads a file: this package only, or also rosparam, whose numbers are written in fewer ways
/// (rosparam_number.h).
enum class YamlReaders { own, rosparam_too };

/// Checks a text before it is built: it has one document, its tags are known, and its aliases do not
/// multiply.
/// @param file its name, for error messages
/// @throws std::runtime_error with one line: file, line, what was expected; YAML::Exception if it is not YAML
void checkYaml(const std::string& text, const std::string& file, YamlReaders readers = YamlReaders::own);

}  // namespace tactile_clay::scene
