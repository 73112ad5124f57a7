#pragma once

#include <string>
#include <vector>

#include "rviz_plugins/service_calls.h"

namespace tactile_clay::rviz_plugins {

/// Services of the rig, to be called by ServiceCalls. The answer is that of the service, or what is wrong.
/// @param name full name of the service, or of the node that simulates the clay

ServiceCalls::Call triggerCall(const std::string& name);
/// @param file name on the computer of the clay
ServiceCalls::Call fileCall(const std::string& name, const std::string& file);
/// @param seconds simulated ones, that the clay goes back
ServiceCalls::Call undoCall(const std::string& clay, double seconds);
ServiceCalls::Call qualityCall(const std::string& clay, const std::string& quality);

/// Presets of the quality of a step that come with the package.
std::vector<std::string> qualities();

}  // namespace tactile_clay::rviz_plugins
