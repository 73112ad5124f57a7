#pragma once

#include <string>

namespace tactile_clay::nodes {

/// Whether a node plays recordings: its name is one that rosbag play takes, such as `/play_1700000000`.
/// @param node full name, as in the header of a connection
inline bool isPlayer(const std::string& node) {
  return node.compare(node.rfind('/') + 1, 5, "play_") == 0;
}

}  // namespace tactile_clay::nodes
