#pragma once

#include <cstddef>
#include <string>

namespace tactile_clay::hand {

/// Unpacks what LZString.compressToBase64 of pieroxy's lz-string made: LZ78 whose codes are one bit longer
/// each time the dictionary has doubled, lowest bit first, in base64. White space is passed over.
/// @param max_bytes of the result
/// @return the text in UTF-8
/// @throws std::runtime_error with a few words where it is none, or is longer
std::string unpackLzString(const std::string& base64, std::size_t max_bytes);

}  // namespace tactile_clay::hand
