#include "rviz_plugins/live_values.h"

#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "nodes/live_parameters.h"
#include "nodes/named_value.h"
#include "values/text.h"

namespace tactile_clay::rviz_plugins {
namespace {

using dynamic_reconfigure::Config;
using Texts = std::map<std::string, std::string>;  // of values, by name

Texts textsOf(const Config& config) {
  Texts texts;
  for (const auto& one : config.bools) texts[one.name] = one.value != 0 ? "true" : "false";
  for (const auto& one : config.ints) texts[one.name] = std::to_string(one.value);
  for (const auto& one : config.doubles) texts[one.name] = values::text(one.value);
  for (const auto& one : config.strs) texts[one.name] = one.value;
  return texts;
}

std::string at(const Texts& texts, const std::string& name) {
  const auto found = texts.find(name);
  return found == texts.end() ? "" : found->second;
}

/// Allowed values in the text of an edit method, a list of Python with `'value': VALUE` in each entry.
std::vector<std::string> choicesIn(const std::string& method) {
  const std::string key = "'value': ";
  std::vector<std::string> choices;
  for (std::size_t begin = method.find(key); begin != std::string::npos; begin = method.find(key, begin)) {
    begin += key.size();
    const bool quoted = method.compare(begin, 1, "'") == 0;
    begin += quoted ? 1 : 0;
    const std::size_t end = method.find_first_of(quoted ? "'" : ",}", begin);
    if (end == std::string::npos) break;
    choices.push_back(method.substr(begin, end - begin));
    begin = end;
  }
  return choices;
}

}  // namespace

std::vector<LiveParameter> liveParameters(const dynamic_reconfigure::ConfigDescription& description,
                                          const Config& values) {
  const Texts now = textsOf(values), low = textsOf(description.min), high = textsOf(description.max),
              fallback = textsOf(description.dflt);
  std::vector<LiveParameter> rows;
  for (const auto& group : description.groups) {
    for (const auto& told : group.parameters) {
      LiveParameter row;
      row.now = {told.name, told.type, at(now, told.name)};
      row.fallback = at(fallback, told.name);
      row.meaning = told.description;
      row.choices =
          told.type == "bool" ? std::vector<std::string>{"true", "false"} : choicesIn(told.edit_method);
      if (told.type == "int" || told.type == "double") {
        row.low = at(low, told.name);
        row.high = at(high, told.name);
        if (row.low == "-inf") row.low.clear();
        if (row.high == "inf") row.high.clear();
      }
      rows.push_back(row);
    }
  }
  return rows;
}

Config configOf(const LiveValue& value) {
  const auto expected = [&](const char* kind) {
    return std::runtime_error(value.name + ": expected " + kind + ", got '" + value.text + "'");
  };
  Config config;
  if (value.type == "str") {
    config.strs.push_back(nodes::namedValue<dynamic_reconfigure::StrParameter>(value.name, value.text));
    return config;
  }
  if (value.type == "bool") {
    const bool truth = value.text == "true";
    if (!truth && value.text != "false") throw expected("true or false");
    config.bools.push_back(nodes::namedValue<dynamic_reconfigure::BoolParameter>(value.name, truth));
    return config;
  }
  const auto numbers = values::numbersOf(value.text);
  if (!numbers || numbers->size() != 1) throw expected("a number");
  const double number = numbers->front();
  if (value.type == "double") {
    config.doubles.push_back(nodes::namedValue<dynamic_reconfigure::DoubleParameter>(value.name, number));
    return config;
  }
  if (number != std::floor(number) || std::abs(number) > std::numeric_limits<int>::max())
    throw expected("a whole number");
  config.ints.push_back(
      nodes::namedValue<dynamic_reconfigure::IntParameter>(value.name, static_cast<int>(number)));
  return config;
}

std::string textOf(const Config& config, const std::string& name) {
  return at(textsOf(config), name);
}

std::string refusalIn(const std::string& line, const std::string& node) {
  const std::string begin = node + nodes::no_change;
  return !node.empty() && line.compare(0, begin.size(), begin) == 0 ? line.substr(begin.size()) : "";
}

std::string liveNodeOf(const std::string& topic, const std::string& type, const std::string& space) {
  const std::string begin = space == "/" ? space : space + "/", end = live_descriptions;
  if (type != ros::message_traits::datatype<dynamic_reconfigure::ConfigDescription>() ||
      topic.size() <= begin.size() + end.size() || topic.compare(0, begin.size(), begin) != 0 ||
      topic.compare(topic.size() - end.size(), end.size(), end) != 0)
    return "";
  return topic.substr(0, topic.size() - end.size());
}

}  // namespace tactile_clay::rviz_plugins
