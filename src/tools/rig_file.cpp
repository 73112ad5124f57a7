#include "tools/rig_file.h"

#include <functional>
#include <map>
#include <regex>
#include <set>
#include <stdexcept>

#include "files/input_file.h"
#include "nodes/array_model.h"
#include "nodes/clay_parameters.h"
#include "nodes/clean_parameters.h"
#include "nodes/focal_point_renderer.h"
#include "nodes/gate_parameters.h"
#include "nodes/settings.h"
#include "nodes/share.h"
#include "scene/rosparam_number.h"
#include "scene/yaml_reader.h"

namespace tactile_clay::tools {
namespace {

const std::set<std::string> poses = {"tracker_pose", "array_pose"};
const std::set<std::string> points = {"head_point", "workspace_low", "workspace_high"};
const std::set<std::string> also_arguments = {"tracker_pose", "head_spl_cap"};  // they have no default value

/// A value without quotes as rosparam reads it: 3e5 is a text.
nodes::SettingValue valueOf(const std::string& text) {
  if (text == "true" || text == "false") return text == "true";
  if (scene::isRosparamWhole(text)) return std::stoi(text);
  if (scene::isRosparamNumber(text)) return std::strtod(text.c_str(), nullptr);
  return text;
}

nodes::SettingValue valueAt(scene::YamlMap& map, const std::string& key) {
  const auto text = map.get<std::string>(key, "a number, true or false, or a text");
  return map.isPlain(key) ? valueOf(text) : nodes::SettingValue(text);
}

/// Arguments of rig.launch that always have a value. It would replace a value of the file.
std::set<std::string> argumentsOfRig() {
  static const std::regex argument("<arg name=\"([a-z_]+)\" default=");
  const std::string text =
      files::readWhole(nodes::packageFolder() + "/launch/rig.launch", files::maximum::text);
  std::set<std::string> names;
  for (auto found = std::sregex_iterator(text.begin(), text.end(), argument); found != std::sregex_iterator();
       ++found)
    names.insert((*found)[1]);
  for (const std::string& name : also_arguments) names.erase(name);
  return names;
}

void readRenderer(nodes::Settings& settings) {
  nodes::focalPointConfig(settings);
  nodes::modulationFrequency(settings);
  nodes::slipGain(settings);
}

/// Reads the parameters of a rig file as the nodes of the rig read them.
void readAll(nodes::Settings& settings, device::SafetyGateConfig gate) {
  nodes::cleanConfig(settings);
  readRenderer(settings);
  nodes::readLimits(settings, gate);
  nodes::ArrayModel().read(settings);
}

/// The keys of a map, separated by commas.
template <typename Map>
std::string listOf(const Map& map) {
  std::string list;
  for (const auto& [name, value] : map) list += (list.empty() ? "" : ", ") + name;
  return list;
}

void requireKnown(const scene::YamlMap& map, const std::string& key, const std::set<std::string>& known) {
  if (known.count(key) > 0) return;
  std::string list;
  for (const std::string& name : known) list += (list.empty() ? "" : ", ") + name;
  map.failAt(key, "unknown key '" + key + "', expected one of " + list);
}

}  // namespace

void requireRigFile(const std::string& file) {
  scene::YamlMap rig = scene::loadYaml(file, scene::YamlReaders::rosparam_too);
  const auto naming = [&](const std::string& key) { return rig.placeOf(key) + "'" + key + "'"; };
  const std::set<std::string> arguments = argumentsOfRig();
  nodes::Settings defaults(naming, {});
  readAll(defaults, {});
  std::set<std::string> known = poses;
  known.insert(points.begin(), points.end());
  for (const nodes::Setting& setting : defaults.read())
    if (arguments.count(setting.name) == 0) known.insert(setting.name);

  nodes::SettingValues values;
  for (const std::string& key : rig.keys()) {
    if (arguments.count(key) > 0)
      rig.failAt(key, "'" + key + "' is an argument of the rig, expected it as " + key + ":=");
    requireKnown(rig, key, known);
    if (poses.count(key) > 0)
      rig.pose(key);
    else if (points.count(key) == 0)
      values[key] = valueAt(rig, key);
  }
  device::SafetyGateConfig gate;
  gate.low = rig.vector("workspace_low", gate.low, "x y z in m");
  gate.high = rig.vector("workspace_high", gate.high, "x y z in m");
  rig.vector("head_point", Eigen::Vector3d::Zero(), "x y z in m");
  nodes::Settings settings(naming, values);
  try {
    readAll(settings, gate);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(file + ": " + error.what());  // errors of the core do not name the file
  }
}

void requirePersonFile(const std::string& file) {
  scene::YamlMap person = scene::loadYaml(file, scene::YamlReaders::rosparam_too);
  const auto naming = [&](const std::string& key) { return person.placeOf(key) + "'" + key + "'"; };
  ultrasound::FocalPointConfig config;
  nodes::Settings defaults(naming, {});
  nodes::readPerson(defaults, config);
  std::set<std::string> known;
  for (const nodes::Setting& setting : defaults.read()) known.insert(setting.name);
  nodes::SettingValues values;
  for (const std::string& key : person.keys()) {
    requireKnown(person, key, known);
    values[key] = valueAt(person, key);
  }
  nodes::Settings settings(naming, values);
  nodes::readPerson(settings, config);
}

void requireParameters(const std::map<std::string, std::string>& parameters, const scene::Scene& scene) {
  using Read = std::function<void(nodes::Settings&)>;
  const Read array = [](nodes::Settings& settings) {
    device::SafetyGateConfig gate;
    nodes::readLimits(settings, gate);
    nodes::ArrayModel().read(settings);
  };
  const std::map<std::string, Read> nodes_of_rig = {
      {"clay_simulator",
       [&](nodes::Settings& settings) { nodes::readClay(settings, scene.config, scene.materials); }},
      {"focal_point_renderer", readRenderer},
      {"hand_tracking", [](nodes::Settings& settings) { nodes::cleanConfig(settings); }},
      {"simulated_array", array},
      {"array_driver", array}};
  const std::set<std::string> arguments = argumentsOfRig();
  std::map<std::string, nodes::SettingValues> values;
  for (const auto& [path, text] : parameters) {
    const std::string node = path.substr(0, path.find('/')), name = path.substr(path.find('/') + 1);
    if (nodes_of_rig.count(node) == 0)
      throw std::runtime_error("parameter '" + path + "': unknown node '" + node + "', expected one of " +
                               listOf(nodes_of_rig));
    if (arguments.count(name) > 0)
      throw std::runtime_error("parameter '" + path + "' is an argument of the rig, expected it as " + name);
    values[node][name] = valueOf(text);
  }
  for (const auto& [node, given] : values) {
    const auto naming = [&node = node](const std::string& name) {
      return "parameter '" + node + "/" + name + "'";
    };
    nodes::Settings settings(naming, given);
    nodes_of_rig.at(node)(settings);
    std::map<std::string, bool> known;
    for (const nodes::Setting& setting : settings.read())
      if (arguments.count(setting.name) == 0) known[setting.name] = true;
    for (const auto& [name, value] : given)
      if (known.count(name) == 0)
        throw std::runtime_error(naming(name) + " is not known, expected one of " + listOf(known));
  }
}

}  // namespace tactile_clay::tools
