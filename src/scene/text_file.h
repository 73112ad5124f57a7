#pragma once

#include <string>

namespace tactile_clay::scene {

/// Text of a file in UTF-8, without a byte order mark.
/// @throws std::runtime_error as files::readWhole, or with file and line of the first byte that is no such
/// text
std::string readText(const std::string& path);

/// @param text loses its byte order mark
/// @param path for errors
/// @throws as readText
void expectUtf8(std::string& text, const std::string& path);

/// One line of a text, for messages: other white space than blanks is taken out.
std::string oneLine(const std::string& text);

}  // namespace tactile_clay::scene
