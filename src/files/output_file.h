#pragma once

#include <string>

namespace tactile_clay::files {

/// What happens to a file that has the name already.
enum class Existing { keep, replace };

/// Writes a file completely or not at all: writes a new file in the same folder, and renames it once it is on
/// the disk. Only a regular file is ever replaced, and only with `Existing::replace`. A link is followed.
/// @throws std::runtime_error with one line "FILE: what was found, what was expected"; the folder is then
/// unchanged
void writeWhole(const std::string& file, const std::string& content, Existing existing);

}  // namespace tactile_clay::files
