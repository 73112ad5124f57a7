#pragma once

#include <string>
#include <vector>

namespace tactile_clay::nodes {

/// What has to be connected before the first message.
struct Connections {
  std::vector<std::string> required;    // topics that must have a publisher and a subscriber
  std::vector<std::string> optional;    // topics whose subscribers, if any, must be connected
  std::string recorder;                 // node that must be connected to all required topics, or empty
  std::vector<std::string> unrecorded;  // topics that it leaves out
};

/// Asks the master and the nodes whether messages would reach everyone: every publisher of these topics is
/// connected to every subscriber that the master knows. Names are resolved names.
/// @return empty if so, else one line about what is missing
std::string missingConnection(const Connections& wanted);

/// Names of the nodes that publish a topic, by its resolved name; none where the master does not answer.
std::vector<std::string> publishersOf(const std::string& topic);

}  // namespace tactile_clay::nodes
