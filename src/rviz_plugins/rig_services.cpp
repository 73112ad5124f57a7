#include "rviz_plugins/rig_services.h"

#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>
#include <tactile_clay/SculptureFile.h>
#include <tactile_clay/Undo.h>
#include <yaml-cpp/yaml.h>

#include "nodes/share.h"

namespace tactile_clay::rviz_plugins {
namespace {

template <typename Service>
bool callService(const std::string& name, Service& service, std::string& answer) {
  if (!ros::service::exists(name, false)) {
    answer = "no node offers the service " + name;
    return false;
  }
  if (ros::service::call(name, service)) return true;
  answer = "the service " + name + " failed";
  return false;
}

}  // namespace

ServiceCalls::Call triggerCall(const std::string& name) {
  return [name](std::string& answer) {
    std_srvs::Trigger request;
    if (!callService(name, request, answer)) return false;
    answer = request.response.message.empty() ? "done" : request.response.message;
    return static_cast<bool>(request.response.success);
  };
}

ServiceCalls::Call fileCall(const std::string& name, const std::string& file) {
  return [name, file](std::string& answer) {
    SculptureFile request;
    request.request.file = file;
    if (!callService(name, request, answer)) return false;
    answer = request.response.message;
    return static_cast<bool>(request.response.success);
  };
}

ServiceCalls::Call undoCall(const std::string& clay, double seconds) {
  return [name = clay + "/undo", seconds](std::string& answer) {
    Undo request;
    request.request.seconds = seconds;
    if (!callService(name, request, answer)) return false;
    answer = request.response.message;
    return static_cast<bool>(request.response.success);
  };
}

ServiceCalls::Call valueCall(const std::string& node, const LiveValue& value) {
  const dynamic_reconfigure::Config config = configOf(value);
  return [service = node + "/set_parameters", name = value.name, config](std::string& answer) {
    dynamic_reconfigure::Reconfigure request;
    request.request.config = config;
    if (!callService(service, request, answer)) return false;
    answer = textOf(request.response.config, name);
    return true;
  };
}

std::vector<std::string> qualities() {
  std::vector<std::string> names;
  try {
    for (const auto& preset : YAML::LoadFile(nodes::packageFolder() + "/config/quality.yaml"))
      names.push_back(preset.first.as<std::string>());
  } catch (const std::exception&) {
    // Then only the quality that the clay publishes is known.
  }
  return names;
}

}  // namespace tactile_clay::rviz_plugins
