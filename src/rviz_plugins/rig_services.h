#pragma once

#include <string>
#include <vector>

#include "rviz_plugins/live_values.h"
#include "rviz_plugins/service_calls.h"

namespace tactile_clay::rviz_plugins {

/// Services of the rig, to be called by ServiceCalls. The answer is that of the service, or what is wrong.
/// @param name full name of the service, or of the node that simulates the clay

ServiceCalls::Call triggerCall(const std::string& name);
/// @param file name on the computer of the clay
ServiceCalls::Call fileCall(const std::string& name, const std::string& file);
/// @param seconds simulated seconds by which the clay goes back
ServiceCalls::Call undoCall(const std::string& clay, double seconds);
/// Asks a node for a value of a live parameter. The answer is the value that it takes.
/// @param node full name
/// @throws std::runtime_error with one line if the text is no value of its type
ServiceCalls::Call valueCall(const std::string& node, const LiveValue& value);

/// Names of the presets of quality that come with the package.
std::vector<std::string> qualities();

}  // namespace tactile_clay::rviz_plugins
