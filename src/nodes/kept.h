#pragma once

#include <string>

namespace tactile_clay::nodes {

/// Environment variables that `keep_running` sets for the program that it starts.
constexpr char beat_variable[] = "TACTILE_CLAY_BEAT";    // descriptor of a pipe, for signs of life
constexpr char folder_variable[] = "TACTILE_CLAY_KEPT";  // folder that outlives the program

/// Name of a file in which a node keeps what it needs when it is started again. The file exists only if the
/// node was started before in this run.
/// @param node its full name
/// @return empty if nobody would start the node again
std::string keptFile(const std::string& node, const std::string& ending);

/// Whether a mark was left in such a file. False for an empty name.
bool isMarked(const std::string& file);
/// Leaves or removes a mark.
/// @return whether this succeeded; true for an empty name, where there is nothing to do
bool mark(const std::string& file, bool marked);

/// Reports that a node is alive. The process writes one sign of life to its keeper, if it has one, only after
/// all its nodes have reported. So one hanging node is noticed even while the others go on.
/// @param node its full name
void beat(const std::string& node);
/// To be called when a node has ended: the process no longer waits for its reports.
void endOfLife(const std::string& node);
/// Names of the nodes whose last sign of life is longer ago than `seconds`, separated by spaces.
std::string silentFor(double seconds);

}  // namespace tactile_clay::nodes
