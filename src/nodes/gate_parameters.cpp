#include "nodes/gate_parameters.h"

#include <ros/console.h>

#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "nodes/params.h"

namespace tactile_clay::nodes {
namespace {

constexpr double no_head_spl_cap = 200.0;  // dB, beyond what any array of these sizes reaches

}  // namespace

std::set<device::Rule> rulesLeftOut(const ros::NodeHandle& private_nh, const std::string& device,
                                    bool harmless) {
  std::set<device::Rule> rules;
  for (const std::string& rule : param(private_nh, "gate_without", std::vector<std::string>())) {
    rules.insert(device::ruleOf(rule));
    if (!harmless)
      throw std::runtime_error("parameter " + private_nh.resolveName("gate_without") +
                               ": leaves out the rule '" + rule + "', expected none: array '" + device +
                               "' is real, and only simulated and debug arrays can do without a rule");
  }
  return rules;
}

void readLimits(Settings& settings, device::SafetyGateConfig& config,
                const device::SafetyGateConfig* maximum) {
  for (const device::Limit& limit : device::limits) {
    double& value = config.*limit.value;
    const double high = maximum ? maximum->*limit.value : limit.high;
    try {
      value = settings.number(limit.name, value, limit.low, high, limit.meaning);
    } catch (const std::runtime_error& error) {
      if (!maximum) throw;
      throw std::runtime_error(error.what() +
                               std::string(": the gate is never made less strict than at its start"));
    }
  }
  config.validate();
}

device::SafetyGateConfig gateConfig(const ros::NodeHandle& nh, bool simulated,
                                    std::set<device::Rule> without) {
  device::SafetyGateConfig config;
  config.without = std::move(without);
  for (const device::Rule rule : config.without)
    ROS_WARN("safety gate without its rule %s, as ~gate_without says", device::nameOf(rule).c_str());
  if (simulated) config.head_spl_cap = no_head_spl_cap;
  const auto text = [](const Eigen::Vector3d& v) {
    return std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z());
  };
  config.low = pointParam(nh, "workspace_low", text(config.low));
  config.high = pointParam(nh, "workspace_high", text(config.high));
  return config;
}

device::StampCheck::Mode stampMode(const ros::NodeHandle& nh) {
  using Mode = device::StampCheck::Mode;
  bool check = true;
  if (nh.getParam("check_stamps", check)) return check ? Mode::on : Mode::off;
  const auto text = param<std::string>(nh, "check_stamps", "true");
  if (text == "auto") return Mode::found;
  if (text == "true" || text == "false") return text == "true" ? Mode::on : Mode::off;
  throw std::runtime_error("parameter " + nh.resolveName("check_stamps") +
                           ": expected true, false or auto, got '" + text + "'");
}

void tellLimits(const device::SafetyGateConfig& config, const std::string& node) {
  std::ostringstream limits;
  limits << config.pressure_cap << " Pa anywhere in the workspace, ";
  if (config.head_spl_cap < no_head_spl_cap)
    limits << config.head_spl_cap << " dB at the head, ";
  else
    limits << "any level at the head, ";
  limits << "intensity " << config.intensity_cap << ", " << config.stale_timeout
         << " s without focal points or hands, and within (" << config.low.transpose() << ") to ("
         << config.high.transpose() << ") m of the array";
  for (const device::Rule rule : config.without) limits << "; WITHOUT its rule " << device::nameOf(rule);
  ROS_INFO("%s: the safety gate allows at most %s", node.c_str(), limits.str().c_str());
}

}  // namespace tactile_clay::nodes
