#pragma once

#include <string>

namespace tactile_clay::scene {

/// The text of an XML file in UTF-8, whatever encoding it declares. Its declaration is changed to UTF-8.
/// @param file for errors
/// @throws std::runtime_error with file and line, if the bytes do not fit the encoding, or it is not known
std::string decodedXml(std::string bytes, const std::string& file);

}  // namespace tactile_clay::scene
