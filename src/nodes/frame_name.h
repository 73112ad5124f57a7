#pragma once

#include <algorithm>
#include <string>

namespace tactile_clay::nodes {

/// Name of a frame as tf2 has it: older senders put a slash in front.
inline std::string frameName(const std::string& name) {
  return name.substr(std::min(name.find_first_not_of('/'), name.size()));
}

}  // namespace tactile_clay::nodes
