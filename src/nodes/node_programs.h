#pragma once

namespace tactile_clay::nodes {

/// Runs a node as a program until it ends.
/// @param name of the program, such as "clay_simulator"
/// @return the program's exit code; 1 after one line of error
int runNode(const char* name, int argc, char** argv);

}  // namespace tactile_clay::nodes
