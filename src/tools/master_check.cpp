#include "tools/master_check.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "nodes/ros_master.h"
#include "tools/tool_arguments.h"

namespace tactile_clay::tools {
namespace {

using RigArguments = std::map<std::string, std::string>;
using XmlRpc::XmlRpcValue;

bool isOn(const RigArguments& arguments, const std::string& key) {
  std::string value = valueOf(arguments, key, "false");
  std::transform(value.begin(), value.end(), value.begin(), [](unsigned char c) { return std::tolower(c); });
  return value != "false";
}

/// Port of `roslaunch -p PORT`, if that is the parent process. It means another master than ROS_MASTER_URI,
/// but roslaunch does not give it to programs that it runs for parameters.
std::string portOfRoslaunch() {
  std::ifstream file("/proc/" + std::to_string(::getppid()) + "/cmdline");
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  bool roslaunch = false;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word.find("roslaunch") != std::string::npos) roslaunch = true;
    if (!roslaunch) continue;
    if ((word == "-p" || word == "--port") && i + 1 < words.size()) return words[i + 1];
    if (word.rfind("--port=", 0) == 0) return word.substr(7);
    if (word.rfind("-p", 0) == 0 && word.size() > 2) return word.substr(2);
  }
  return "";
}

std::string masterUri() {
  const std::string port = portOfRoslaunch();
  if (!port.empty()) return "http://localhost:" + port + "/";
  const char* uri = std::getenv("ROS_MASTER_URI");
  return uri == nullptr || *uri == '\0' ? "http://localhost:11311/" : uri;
}

void requireFreeNames(const nodes::Address& master, const RigArguments& arguments) {
  const char* given = std::getenv("ROS_NAMESPACE");
  std::string space = given == nullptr ? "/" : given;
  if (space.empty() || space.front() != '/') space.insert(0, 1, '/');
  if (space.back() != '/') space += '/';
  std::vector<std::string> names;
  for (const std::string& name : nodesOfRig(arguments)) names.push_back(space + name);
  const auto others = nodes::runningForGood(master, names);
  if (others.empty()) return;
  std::string ends = "rosnode kill";
  for (const nodes::RunningNode& node : others) ends += " " + node.name;
  throw std::runtime_error("nodes of a rig run on this master already, such as " + others.front().words +
                           ": end them (" + ends +
                           "), or give this rig a namespace of its own (ROS_NAMESPACE=NAME)");
}

/// Requires that somebody publishes the clock if it is simulated. Hands of a topic may come from a player
/// whose clock begins later, and lockstep needs no clock.
void requireClock(const nodes::Address& master, const RigArguments& arguments) {
  if (valueOf(arguments, "hands", "bag") == "topic" || isOn(arguments, "lockstep")) return;
  auto simulated = nodes::ask(master, "getParam", {"/use_sim_time"});
  if (!simulated || simulated->getType() != XmlRpcValue::TypeBoolean || !static_cast<bool>(*simulated))
    return;
  auto state = nodes::ask(master, "getSystemState");
  if (!state || state->getType() != XmlRpcValue::TypeArray || state->size() != 3) return;
  XmlRpcValue& publishers = (*state)[0];
  for (int i = 0; i < publishers.size(); ++i)
    if (static_cast<std::string>(publishers[i][0]) == "/clock") return;
  throw std::runtime_error(
      "use_sim_time is true on this master, and nobody publishes /clock: no time would pass. Start the clock "
      "first, or `rosparam delete /use_sim_time`");
}

}  // namespace

std::vector<std::string> nodesOfRig(const RigArguments& arguments) {
  std::vector<std::string> names = {"hand_tracking",    "hand_simulator",       "clay_simulator",
                                    "clay_surface",     "hand_surface",         "rig_numbers",
                                    "contact_pressure", "focal_point_renderer", "robot_state_publisher"};
  names.push_back(valueOf(arguments, "device", "simulated") == "simulated" ? "simulated_array"
                                                                           : "array_driver");
  if (!valueOf(arguments, "wire", "").empty()) names.push_back("boards");
  if (isOn(arguments, "skeleton"))
    names.insert(names.end(), {"hand_skeleton", "hand_left_state_publisher", "hand_right_state_publisher"});
  if (isOn(arguments, "nodelets")) names.push_back("manager");
  if (isOn(arguments, "diagnostics")) names.push_back("diagnostic_aggregator");
  if (isOn(arguments, "record")) names.insert(names.end(), {"describe_rig", "record"});
  return names;
}

void requireRoomOnMaster(const RigArguments& arguments) {
  const auto master = nodes::addressOf(masterUri());
  if (!master || !nodes::ask(*master, "getPid")) return;  // roslaunch starts one
  requireFreeNames(*master, arguments);
  requireClock(*master, arguments);
}

}  // namespace tactile_clay::tools
