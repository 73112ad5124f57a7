#pragma once

#include <map>
#include <string>
#include <vector>

namespace tactile_clay::tools {

/// Names of the nodes that rig.launch starts with these arguments, in its own namespace.
std::vector<std::string> nodesOfRig(const std::map<std::string, std::string>& arguments);

/// Looks at the master on which a rig of these arguments is about to start, if one is there.
/// @throws std::runtime_error with one line where nodes of its names run, which the master would end in its
/// favour, or where the rig would wait for a clock that nobody publishes
void requireRoomOnMaster(const std::map<std::string, std::string>& arguments);

}  // namespace tactile_clay::tools
