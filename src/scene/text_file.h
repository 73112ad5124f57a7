#pragma once

#include <string>

namespace tactile_clay::scene {

/// Text of a file in UTF-8, without a byte order mark.
/// @throws std::runtime_error as files::readWhole, or with file and line of the first byte that is not UTF-8,
/// or of the first control character other than tab and line ends; UTF-16 is refused without a line
std::string readText(const std::string& path);

/// @param text loses its byte order mark
/// @param path for errors
/// @throws as readText
void expectUtf8(std::string& text, const std::string& path);

/// A text as one line, for messages: each run of white space becomes one blank, and none is left at the ends.
std::string oneLine(const std::string& text);

}  // namespace tactile_clay::scene
