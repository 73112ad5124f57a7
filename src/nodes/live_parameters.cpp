#include "nodes/live_parameters.h"

#include <dynamic_reconfigure/ConfigDescription.h>
#include <tactile_clay/ParameterChange.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "nodes/named_value.h"
#include "nodes/params.h"
#include "nodes/topics.h"
#include "values/text.h"

namespace tactile_clay::nodes {
namespace {

using dynamic_reconfigure::Config;

/// Names of the groups by their numbers. Group 0 is the node itself.
std::vector<std::string> groupsOf(const std::vector<Setting>& settings) {
  std::vector<std::string> groups = {""};
  for (const Setting& setting : settings)
    if (std::find(groups.begin(), groups.end(), setting.group) == groups.end())
      groups.push_back(setting.group);
  return groups;
}

void addTo(Config& config, const std::string& name, const SettingValue& value) {
  if (const bool* truth = std::get_if<bool>(&value))
    config.bools.push_back(namedValue<dynamic_reconfigure::BoolParameter>(name, *truth));
  else if (const int* whole = std::get_if<int>(&value))
    config.ints.push_back(namedValue<dynamic_reconfigure::IntParameter>(name, *whole));
  else if (const double* number = std::get_if<double>(&value))
    config.doubles.push_back(namedValue<dynamic_reconfigure::DoubleParameter>(name, *number));
  else
    config.strs.push_back(namedValue<dynamic_reconfigure::StrParameter>(name, std::get<std::string>(value)));
}

/// A Config with one value per setting, and with the groups of the settings.
template <class ValueOf>
Config configOf(const std::vector<Setting>& settings, ValueOf value_of) {
  Config config;
  for (const Setting& setting : settings) addTo(config, setting.name, value_of(setting));
  const std::vector<std::string> groups = groupsOf(settings);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    dynamic_reconfigure::GroupState group;
    group.name = k == 0 ? "Default" : groups[k];
    group.state = true;
    group.id = static_cast<int>(k);
    config.groups.push_back(group);
  }
  return config;
}

Config configOf(const std::vector<Setting>& settings, const SettingValues& values) {
  return configOf(settings, [&](const Setting& setting) { return values.at(setting.name); });
}

/// The choices as text, as rqt_reconfigure and dynparam read it: a map of Python.
std::string editMethod(const Setting& setting) {
  if (setting.choices.empty()) return "";
  std::string list;
  for (const std::string& choice : setting.choices)
    list += (list.empty() ? "" : ", ") + ("{'name': '" + choice + "', 'type': 'str', 'value': '" + choice +
                                          "', 'description': '', 'ctype': 'std::string'}");
  return "{'enum': [" + list + "], 'enum_description': ''}";
}

dynamic_reconfigure::ConfigDescription descriptionOf(const std::vector<Setting>& settings) {
  constexpr const char* types[] = {"bool", "int", "double", "str"};  // in the order of SettingValue
  dynamic_reconfigure::ConfigDescription description;
  const std::vector<std::string> groups = groupsOf(settings);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    dynamic_reconfigure::Group group;
    group.name = k == 0 ? "Default" : groups[k];
    group.id = static_cast<int>(k);
    for (const Setting& setting : settings) {
      if (setting.group != groups[k]) continue;
      dynamic_reconfigure::ParamDescription told;
      told.name = setting.name;
      told.type = types[setting.value.index()];
      told.description = setting.meaning;
      told.edit_method = editMethod(setting);
      group.parameters.push_back(told);
    }
    description.groups.push_back(group);
  }
  description.min = configOf(settings, [](const Setting& setting) { return setting.low; });
  description.max = configOf(settings, [](const Setting& setting) { return setting.high; });
  description.dflt = configOf(settings, [](const Setting& setting) { return setting.fallback; });
  return description;
}

SettingValues valuesOf(const Config& config) {
  SettingValues values;
  for (const auto& one : config.bools) values[one.name] = static_cast<bool>(one.value);
  for (const auto& one : config.ints) values[one.name] = static_cast<int>(one.value);
  for (const auto& one : config.doubles) values[one.name] = one.value;
  for (const auto& one : config.strs) values[one.name] = one.value;
  return values;
}

/// A YAML map in one line. Its numbers are read back to the same bits.
std::string asYaml(const SettingValues& values) {
  YAML::Emitter out;
  out << YAML::Flow << YAML::BeginMap;
  out.SetDoublePrecision(std::numeric_limits<double>::max_digits10);
  for (const auto& [name, value] : values) {
    out << YAML::Key << YAML::DoubleQuoted << name << YAML::Value;
    if (const auto* text = std::get_if<std::string>(&value))
      out << YAML::DoubleQuoted << *text;
    else if (const bool* truth = std::get_if<bool>(&value))
      out << *truth;
    else if (const int* whole = std::get_if<int>(&value))
      out << *whole;
    else
      out << std::get<double>(value);
  }
  out << YAML::EndMap;
  std::string line = out.c_str();
  std::replace(line.begin(), line.end(), '\n', ' ');  // where the emitter breaks a long map
  return line;
}

/// The value of a node, of the same type as `example`.
/// @throws YAML::Exception if the node has another type
SettingValue valueOf(const YAML::Node& node, const SettingValue& example) {
  return std::visit([&](const auto& kind) -> SettingValue { return node.as<std::decay_t<decltype(kind)>>(); },
                    example);
}

}  // namespace

LiveParameters::LiveParameters(ros::NodeHandle nh, ros::NodeHandle private_nh, Read read)
    : space_(private_nh.getNamespace()), read_(std::move(read)), private_nh_(private_nh) {
  naming_ = [private_nh](const std::string& name) { return "parameter " + private_nh.resolveName(name); };
  const std::string rig = nh.getNamespace();
  node_ = space_.substr(rig.size() + (rig == "/" ? 0 : 1));
  Settings start(private_nh);
  const Apply apply = read_(start);
  stored_ = values_ = start.values();
  apply();
  // Ranges from now on may be narrower than those at the start.
  Settings from_now_on(naming_, values_);
  read_(from_now_on);
  settings_ = from_now_on.read();
  readChanges(param<std::string>(private_nh, "changes", ""));

  told_ = nh.advertise<ParameterChange>(topic::changes, 100);
  descriptions_ =
      private_nh.advertise<dynamic_reconfigure::ConfigDescription>("parameter_descriptions", 1, true);
  updates_ = private_nh.advertise<Config>("parameter_updates", 1, true);
  descriptions_.publish(descriptionOf(settings_));
  updates_.publish(configOf(settings_, values_));
  server_ = private_nh.advertiseService("set_parameters", &LiveParameters::reconfigure, this);
  timer_ =
      private_nh.createWallTimer(ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) { store(); });
}

void LiveParameters::readChanges(const std::string& text) {
  if (text.empty()) return;
  try {
    for (const YAML::Node& entry : YAML::Load(text)) {
      const auto stamp = entry["stamp"].as<std::vector<std::uint32_t>>();
      changes_.push_back({ros::Time(stamp.at(0), stamp.at(1)), entry["parameters"].as<std::string>()});
    }
  } catch (const std::exception& error) {
    throw std::runtime_error(
        naming_("changes") +
        ": expected a list of {stamp: [s, ns], parameters: 'a map in YAML'}: " + error.what());
  }
}

SettingValues LiveParameters::fromYaml(const std::string& text) const {
  SettingValues values;
  for (const auto& entry : YAML::Load(text)) {
    const auto name = entry.first.as<std::string>();
    const auto known = values_.find(name);
    if (known == values_.end()) refuseName(name, values_);
    try {
      values[name] = valueOf(entry.second, known->second);
    } catch (const YAML::Exception&) {
      throw std::runtime_error(naming_(name) + ": expected " + kindOf(known->second));
    }
  }
  return values;
}

void LiveParameters::refuseName(const std::string& name, const SettingValues& known) const {
  std::string list;
  for (const auto& one : known) list += (list.empty() ? "" : ", ") + one.first;
  throw std::runtime_error(naming_(name) + " cannot change while the node runs, expected one of " + list);
}

// Called with the mutex locked.
void LiveParameters::ask(const SettingValues& values) {
  SettingValues wanted = pending_ ? pending_->values : values_;
  for (const auto& [name, value] : values) {
    const auto known = wanted.find(name);
    if (known == wanted.end()) refuseName(name, wanted);
    known->second = value;
  }
  Settings settings(naming_, std::move(wanted));
  Apply apply = read_(settings);
  pending_ = Pending{settings.values(), std::move(apply)};
}

bool LiveParameters::reconfigure(dynamic_reconfigure::Reconfigure::Request& request,
                                 dynamic_reconfigure::Reconfigure::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  try {
    ask(valuesOf(request.config));
  } catch (const std::exception& error) {
    ROS_WARN("%s%s%s", space_.c_str(), no_change, values::printableLine(error.what()).c_str());
    // A display that shows the refused values then shows the present ones again.
    updates_.publish(configOf(settings_, values_));
    return false;
  }
  response.config = configOf(settings_, pending_->values);
  return true;
}

void LiveParameters::change(const SettingValues& values) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ask(values);
}

// Not called from begin(), because the master may take any time to answer.
void LiveParameters::store() {
  SettingValues values;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    values = values_;
  }
  for (const auto& [name, value] : values) {
    if (stored_.at(name) == value) continue;
    std::visit([&, &name = name](const auto& v) { private_nh_.setParam(name, v); }, value);
    stored_[name] = value;
  }
}

void LiveParameters::begin(ros::Time stamp) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (; !changes_.empty() && changes_.front().stamp <= stamp; changes_.pop_front())
    ask(fromYaml(changes_.front().values));
  if (!pending_) return;
  const Pending change = std::move(*pending_);
  pending_.reset();
  if (change.values == values_) return;
  const SettingValues before = std::move(values_);
  values_ = change.values;
  change.apply();
  tell(before, stamp);
}

// Called with the mutex locked.
void LiveParameters::tell(const SettingValues& before, ros::Time stamp) {
  SettingValues changed;
  for (const auto& [name, value] : values_)
    if (before.at(name) != value) changed[name] = value;
  ParameterChange change;
  change.header.stamp = stamp;
  change.node = node_;
  change.parameters = asYaml(changed);
  told_.publish(change);
  updates_.publish(configOf(settings_, values_));
  ROS_INFO("%s: changed from the frame of %u.%09u s on: %s", space_.c_str(), stamp.sec, stamp.nsec,
           change.parameters.c_str());
}

}  // namespace tactile_clay::nodes
