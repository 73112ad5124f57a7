#pragma once

#include <string>

namespace tactile_clay::scene {

constexpr std::size_t most_text = std::size_t{16}
                                  << 20;  // bytes of a text file: a scene or a robot model is far smaller

/// Bytes of a regular file. A device or a pipe could keep a reader waiting for ever.
/// \throws std::runtime_error with one line where it cannot be read, or is larger than `most` bytes
std::string readBytes(const std::string& path, std::size_t most = most_text);

/// Text of a file in UTF-8, without a byte order mark.
/// \throws std::runtime_error with one line as above, or with file and line of the first byte that is no such
/// text
std::string readText(const std::string& path);

/// \param text loses its byte order mark \param path for errors \throws as readText
void expectUtf8(std::string& text, const std::string& path);

/// One line of a text, for messages: other white space than blanks is taken out.
std::string oneLine(const std::string& text);

}  // namespace tactile_clay::scene
