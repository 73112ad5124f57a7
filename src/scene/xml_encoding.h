#pragma once

#include <string>

namespace tactile_clay::scene {

/// The text of an XML file in UTF-8, whatever encoding it declares. The declaration says so then.
/// @param file for errors
/// @throws std::runtime_error with file and line, where the bytes are not of the encoding, or it is not known
std::string decodedXml(std::string bytes, const std::string& file);

}  // namespace tactile_clay::scene
