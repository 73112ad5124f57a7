#pragma once

#include <string>

namespace tactile_clay::files {

/// What is to become of a file that has the name already.
enum class Existing { keep, replace };

/// Writes a file whole or not at all: into a new file of the same folder, which takes the name when it is on
/// the disk. Only a regular file is ever replaced, and only by `Existing::replace`; a link is followed.
/// @throws std::runtime_error with one line "FILE: what was found, what was expected"; the folder is then as
/// it was
void writeWhole(const std::string& file, const std::string& content, Existing existing);

}  // namespace tactile_clay::files
