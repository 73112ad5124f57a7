#pragma once

#include <string>

namespace tactile_clay::files {

/// Whether a text, such as the name of a file, ends with `end`.
inline bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

}  // namespace tactile_clay::files
