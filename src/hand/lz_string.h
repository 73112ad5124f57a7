#pragma once

#include <cstddef>
#include <string>

namespace tactile_clay::hand {

/// Unpacks the output of LZString.compressToBase64 of pieroxy's lz-string: LZ78, lowest bit first, in base64.
/// Its codes become one bit longer each time the dictionary has doubled. White space is ignored.
/// @param max_bytes maximum size of the result
/// @return the text in UTF-8; half a letter alone (a surrogate) becomes U+FFFD
/// @throws std::runtime_error with a few words if the text is not of this form, or if the result is longer
std::string unpackLzString(const std::string& base64, std::size_t max_bytes);

}  // namespace tactile_clay::hand
