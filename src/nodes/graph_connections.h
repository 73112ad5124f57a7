#pragma once

#include <string>
#include <vector>

namespace tactile_clay::nodes {

/// Asks the master and the nodes whether messages would reach everyone: on each of the topics there is a publisher and a
/// subscriber, and every publisher is connected to every subscriber that the master knows.
/// \param topics resolved names
/// \return empty if so, else one line about what is missing
std::string missingConnection(const std::vector<std::string>& topics);

}  // namespace tactile_clay::nodes
