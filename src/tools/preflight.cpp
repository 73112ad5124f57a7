#include <ros/console.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

#include "device/array_device.h"
#include "device/options.h"
#include "files/input_file.h"
#include "hand/hand_cleaner.h"
#include "hand/hand_source.h"
#include "hand/leap_websocket.h"
#include "nodes/plugin.h"
#include "nodes/share.h"
#include "nodes/supervisors.h"
#include "scene/quality.h"
#include "scene/robot_model.h"
#include "scene/scene.h"
#include "scene/solids.h"
#include "scene/yaml_reader.h"
#include "tools/master_check.h"
#include "tools/rig_file.h"
#include "tools/tool_arguments.h"
#include "tools/user_paths.h"
#include "ultrasound/array_layout.h"
#include "ultrasound/modulation.h"
#include "ultrasound/phase_solver.h"
#include "values/text.h"

namespace {

constexpr char usage[] =
    R"(Checks the arguments of rig.launch with the loaders of the nodes, before anything starts. Prints the robot model
of the scene. If something is wrong, prints one line and exits with 1.

  preflight [scene:=NAME] [quality:=NAME] [hands:=SOURCE] [file:=PATH] [device:=NAME] [record:=BAG] [...]

NODE/NAME:=VALUE is a parameter of a node, and is checked, too. Other arguments of rig.launch are ignored. One word
may have several arguments, one per line. Names of files are relative to the working directory. starts:=true means
that a rig is about to start: the program also checks that no other rig runs on the master.
)";

using Arguments = std::map<std::string, std::string>;
namespace clay = tactile_clay;
using clay::tools::valueOf;

std::string lowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

/// Whether a name means a file of config/: it has no folder and no ending.
bool isOfConfig(const std::string& name) {
  const std::string ending = ".yaml";
  return name.find('/') == std::string::npos &&
         (name.size() < ending.size() ||
          name.compare(name.size() - ending.size(), ending.size(), ending) != 0);
}

/// Makes the names of files absolute, as rig.launch needs them.
void nameFiles(Arguments& arguments) {
  const std::string here = std::filesystem::current_path().string(), home = environment("HOME");
  const auto name = [&](const std::string& key) {
    arguments[key] = clay::tools::userPath(arguments[key], key, here, home);
  };
  if (!isOfConfig(arguments["scene"])) name("scene");
  if (!arguments["material"].empty() && !isOfConfig(arguments["material"])) name("material");
  if (arguments["hands"] != "choreography" || !isOfConfig(arguments["file"])) name("file");
  for (const char* key : {"rig", "person"})
    if (!arguments[key].empty()) name(key);
  const std::string record = lowerCase(arguments["record"]);
  if (record == "true")
    clay::tools::requireFolderToWrite(here);
  else if (!record.empty() && record != "false") {
    name("record");
    clay::tools::requireNewBag(arguments["record"]);
  }
}

Arguments parse(int argc, char** argv) {
  Arguments arguments = {{"scene", "kindergarten"},
                         {"quality", "balanced"},
                         {"solver", ""},
                         {"hands", "bag"},
                         {"file", ""},
                         {"device", "simulated"},
                         {"hand_model", "kinematic"},
                         {"tracker_pose", ""},
                         {"rig", ""},
                         {"person", ""},
                         {"url", ""}};
  for (int i = 1; i < argc; ++i)
    for (const std::string& argument : clay::tools::argumentLines(argv[i])) {
      const std::size_t at = argument.find(":=");
      if (at != std::string::npos && argument.substr(0, 2) != "__")
        arguments[argument.substr(0, at)] = argument.substr(at + 2);
    }
  std::string& file = arguments.at("file");
  if (file.empty())
    file = arguments.at("hands") == "choreography" ? "kneading"
                                                   : clay::nodes::packageFolder() + "/test/bags/knead.bag";
  nameFiles(arguments);
  return arguments;
}

void checkHands(const Arguments& arguments) {
  const std::string& file = arguments.at("file");
  clay::nodes::Plugin<clay::hand::HandSource> source("tactile_clay::hand::HandSource", "source of hands",
                                                     arguments.at("hands"));
  if (arguments.at("hands") == "leap_websocket") clay::hand::parseWebsocketUrl(arguments.at("url"));
  const bool scripted = arguments.at("hands") == "choreography";
  const bool needs_file =
      arguments.at("hands") == "bag" || arguments.at("hands") == "leap_recording" || scripted;
  if (!needs_file) return;
  if (!scripted) clay::files::requireInput(file, clay::files::maximum::recording);
  clay::hand::SourceOptions options;
  options.file = file;
  options.topic = valueOf(arguments, "topic", "");
  source->open(options);
}

void checkDevice(const Arguments& arguments) {
  const std::string& name = arguments.at("device");
  if (name == "simulated") return;
  const clay::nodes::Plugin<clay::device::ArrayDevice> device("tactile_clay::device::ArrayDevice", "device",
                                                              name, "simulated");
  auto options = clay::device::optionsOf("device_options", valueOf(arguments, "device_options", ""));
  clay::device::requireNoTemperature("device_options", options);
  const std::string wire = valueOf(arguments, "wire", "");
  const std::string port = wire.empty() ? valueOf(arguments, "port", "") : wire;
  if (!port.empty()) options["port"] = port;
  // Nodes run in this folder. Names of files among the options are relative to it; all others are absolute by
  // now.
  const std::string ros_home = environment("ROS_HOME");
  std::error_code none;  // of a folder that does not exist, there are no relative names
  std::filesystem::current_path(ros_home.empty() ? environment("HOME") + "/.ros" : ros_home, none);
  device->requireOptions(options);
}

void checkPose(const std::string& text) {
  if (text.empty()) return;
  const auto numbers = clay::values::numbersOf(text);
  if (!numbers || numbers->size() != 6)
    throw std::runtime_error("tracker_pose '" + text + "': expected \"x y z roll pitch yaw\", 6 numbers");
}

void check(const Arguments& arguments, const std::string& key, double low, double high) {
  const auto found = arguments.find(key);
  if (found != arguments.end()) clay::tools::numberOf(key, found->second, low, high);
}

void checkWhole(const Arguments& arguments, const std::string& key, int low, int high) {
  const auto found = arguments.find(key);
  if (found != arguments.end()) clay::tools::wholeOf(key, found->second, low, high);
}

void checkSwitch(const Arguments& arguments, const std::string& key) {
  const auto found = arguments.find(key);
  if (found == arguments.end()) return;
  const std::string value = lowerCase(found->second);  // roslaunch accepts upper and lower case
  if (value != "true" && value != "false")
    throw std::runtime_error(key + " '" + found->second + "': expected true or false");
}

/// Checks the numbers and the poses of the package's rig file. The nodes read them from the parameter server,
/// which does not know their lines.
void checkRig(const std::string& file) {
  clay::scene::YamlMap rig = clay::scene::loadYaml(file, clay::scene::YamlReaders::rosparam_too);
  for (const char* key : {"tracker_pose", "array_pose"})
    if (rig.isList(key)) rig.pose(key);
  if (rig.isList("head_point")) rig.numbers("head_point", 3, "x y z in m");
}

void requirePackage(const std::string& name) {
  if (!clay::nodes::hasPackage(name))
    throw std::runtime_error("diagnostics 'true': the package " + name +
                             " is not found, expected it on ROS_PACKAGE_PATH");
}

void checkParameters(const Arguments& arguments, const clay::scene::Scene& scene) {
  Arguments parameters;
  for (const auto& [name, value] : arguments)
    if (name.find('/') != std::string::npos) parameters[name] = value;
  clay::tools::requireParameters(parameters, scene);
}

/// Checks the quality before any node starts, as the node itself does: in lockstep, or with a budget of one's
/// own, the quality cannot be fitted to the computer.
void checkQuality(const Arguments& arguments, const std::string& package) {
  for (const char* key : {"substeps", "iterations"}) checkWhole(arguments, key, 0, 1000);
  check(arguments, "target_ms", 0.0, 1000.0);
  checkSwitch(arguments, "lockstep");
  const auto number = [&](const char* key) { return std::stod(valueOf(arguments, key, "0")); };
  clay::scene::QualityWish wish;
  wish.quality = arguments.at("quality");
  wish.target_ms = number("target_ms");
  wish.lockstep = lowerCase(valueOf(arguments, "lockstep", "false")) == "true";
  wish.solver = arguments.at("solver");
  wish.substeps = static_cast<int>(number("substeps"));
  wish.iterations = static_cast<int>(number("iterations"));
  clay::scene::requireQuality(wish, clay::scene::loadQualities(package));
}

std::string checkAll(const Arguments& arguments) {
  const std::string package = clay::nodes::packageFolder();
  const clay::scene::Scene scene = clay::scene::loadScene(
      arguments.at("scene"), package, 0.0, clay::nodes::folderOfPackage, valueOf(arguments, "material", ""));
  const std::string urdf = clay::scene::loadRobotModel(scene.urdf);
  try {
    clay::scene::Solids(urdf, scene.motions, clay::nodes::folderOfPackage);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(scene.urdf + ": " + error.what());
  }
  checkQuality(arguments, package);
  checkRig(package + "/config/rig.yaml");
  if (const std::string rig = valueOf(arguments, "rig", ""); !rig.empty()) clay::tools::requireRigFile(rig);
  if (const std::string& person = arguments.at("person"); !person.empty())
    clay::tools::requirePersonFile(person);
  if (!arguments.at("solver").empty()) clay::clay::methodNamed(arguments.at("solver"));
  if (arguments.at("hand_model") != "kinematic" && arguments.at("hand_model") != "soft")
    throw std::runtime_error("unknown hand_model '" + arguments.at("hand_model") +
                             "': expected kinematic or soft");
  checkHands(arguments);
  checkPose(arguments.at("tracker_pose"));
  checkDevice(arguments);
  clay::nodes::requiredSupervisors(valueOf(arguments, "supervisors", "none"));
  if (const std::string modulation = valueOf(arguments, "modulation", "auto"); modulation != "auto")
    clay::ultrasound::modulation(modulation);
  clay::ultrasound::arrayLayouts(valueOf(arguments, "layout", "usx"));
  clay::ultrasound::phaseMethod(valueOf(arguments, "phase_method", "newton"));
  for (const char* key : {"loop", "skeleton", "perceptual_weights", "nodelets", "sleeping", "rviz",
                          "diagnostics", "record_skin"})
    checkSwitch(arguments, key);
  if (valueOf(arguments, "clean", "auto") != "auto") checkSwitch(arguments, "clean");
  if (!valueOf(arguments, "head_spl_cap", "").empty()) check(arguments, "head_spl_cap", 0.0, 200.0);
  if (lowerCase(valueOf(arguments, "diagnostics", "false")) == "true")
    requirePackage("diagnostic_aggregator");
  const std::string compression = valueOf(arguments, "record_compression", "none");
  if (compression != "none" && compression != "lz4" && compression != "bz2")
    throw std::runtime_error("record_compression '" + compression + "': expected none, lz4 or bz2");
  checkWhole(arguments, "phase_levels", 0, 65536);
  check(arguments, "rate", 0.01, 100.0);
  check(arguments, "prediction", 0.0, clay::hand::max_prediction);
  check(arguments, "duration", 0.0, 1e9);
  checkWhole(arguments, "threads", 0, 1024);
  checkWhole(arguments, "max_points", 1, 256);
  checkParameters(arguments, scene);
  if (valueOf(arguments, "starts", "") == "true") clay::tools::requireRoomOnMaster(arguments);
  return urdf;
}

/// The standard output of the program. After this call other output, such as that of ROS_INFO, goes to the
/// standard error, because roslaunch takes all of the standard output for the robot model.
std::FILE* takeOutput() {
  std::FILE* const output = fdopen(dup(STDOUT_FILENO), "w");
  if (output == nullptr || dup2(STDERR_FILENO, STDOUT_FILENO) < 0)
    throw std::runtime_error(std::string("the standard output cannot be used: ") + std::strerror(errno));
  return output;
}

}  // namespace

int main(int argc, char** argv) {
  return clay::tools::runTool("tactile_clay", usage, argc, argv, [&] {
    std::FILE* const output = takeOutput();
    const std::string model = checkAll(parse(argc, argv));
    if (std::fputs(model.c_str(), output) == EOF || std::fclose(output) != 0)
      throw std::runtime_error(std::string("the robot model cannot be written: ") + std::strerror(errno));
  });
}
