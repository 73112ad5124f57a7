#pragma once

#include <algorithm>
#include <string>

namespace tactile_clay::nodes {

/// Name of a coordinate frame as in tf2. Older senders put a slash in front, which is removed.
inline std::string frameName(const std::string& name) {
  return name.substr(std::min(name.find_first_not_of('/'), name.size()));
}

}  // namespace tactile_clay::nodes
