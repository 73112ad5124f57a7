#pragma once

#include <algorithm>
#include <string>

namespace tactile_clay::nodes {

/// Whether a node plays recordings: its name is one that rosbag play takes, such as
/// `/play_1700000000123456789`, or roslaunch for `$(anon play)`. A live node, such as `/play_area`, must not
/// be taken for it.
/// @param node full name, as in the header of a connection
inline bool isPlayer(const std::string& node) {
  constexpr std::ptrdiff_t shortest = 8;  // digits of a time or a random number
  const auto digits =
      std::find_if(node.rbegin(), node.rend(), [](char c) { return c < '0' || c > '9'; }) - node.rbegin();
  return node.compare(node.rfind('/') + 1, 5, "play_") == 0 && digits >= shortest;
}

}  // namespace tactile_clay::nodes
