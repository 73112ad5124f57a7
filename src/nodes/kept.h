#pragma once

#include <string>

namespace tactile_clay::nodes {

/// What `keep_running` tells the program that it starts, as variables of its environment.
constexpr char beat_variable[] = "TACTILE_CLAY_BEAT";    // descriptor of a pipe, for signs of life
constexpr char folder_variable[] = "TACTILE_CLAY_KEPT";  // folder that outlives the program

/// A file in which a node leaves what it needs when it is started again; it is there only where the node was
/// started before in this run.
/// @param node its full name
/// @return empty where nobody would start it again
std::string keptFile(const std::string& node, const std::string& ending);

/// Whether a mark was left in such a file. An empty name: no.
bool isMarked(const std::string& file);
/// Leaves or takes away a mark.
/// @return whether that went well; an empty name: nothing is to do
bool mark(const std::string& file, bool marked);

/// Gives a sign of life of a node, where somebody waits for it. The process gives one when each of its nodes
/// has: one that hangs among others that go on is noticed too.
/// @param node its full name
void beat(const std::string& node);
/// The node has ended, and is not waited for any more.
void endOfLife(const std::string& node);
/// Nodes that have been silent longer than that, s, since their last sign of life, separated by spaces.
std::string silentFor(double seconds);

}  // namespace tactile_clay::nodes
