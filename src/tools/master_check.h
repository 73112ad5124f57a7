#pragma once

#include <map>
#include <string>
#include <vector>

namespace tactile_clay::tools {

/// Names of the nodes that rig.launch starts with these arguments, in its own namespace.
std::vector<std::string> nodesOfRig(const std::map<std::string, std::string>& arguments);

/// Checks the master, if there is one, on which a rig with these arguments is about to start.
/// @throws std::runtime_error with one line if nodes with the names of the rig's nodes run, which the master
///   would end, or if the rig would wait for a clock that nobody publishes
void requireRoomOnMaster(const std::map<std::string, std::string>& arguments);

}  // namespace tactile_clay::tools
