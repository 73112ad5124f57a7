#pragma once

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>

#include <string>
#include <vector>

namespace tactile_clay::rviz_plugins {

/// Behind the full name of a node: its topics with the description of its live parameters and their values.
constexpr char live_descriptions[] = "/parameter_descriptions", live_updates[] = "/parameter_updates";

/// A value of a live parameter, as text.
struct LiveValue {
  std::string name;
  std::string type;  // bool, int, double or str
  std::string text;
};

/// A live parameter of a node, as a row of a table.
struct LiveParameter {
  LiveValue now;                     // present value; its text is empty if it is not known
  std::string low, high;             // range of a number; empty: no limit
  std::string fallback;              // default of the node
  std::string meaning;               // with its unit
  std::vector<std::string> choices;  // the allowed values; empty: no list
};

/// The parameters of a node, in the order in which it describes them.
/// @param values present values; values of other parameters are ignored
std::vector<LiveParameter> liveParameters(const dynamic_reconfigure::ConfigDescription& description,
                                          const dynamic_reconfigure::Config& values);

/// A request for one value.
/// @throws std::runtime_error with one line if the text is no value of this type
dynamic_reconfigure::Config configOf(const LiveValue& value);

/// A value of a Config as text; empty if there is none of this name.
std::string textOf(const dynamic_reconfigure::Config& config, const std::string& name);

/// The reason why a node changed no parameter, from a line of its log; empty for all other lines.
/// @param node its full name
std::string refusalIn(const std::string& line, const std::string& node);

/// The node of a topic on which it describes its live parameters.
/// @param type of the topic
/// @param space namespace of the nodes that are looked for, such as `/`
/// @return its full name; empty if the topic is another one
std::string liveNodeOf(const std::string& topic, const std::string& type, const std::string& space);

}  // namespace tactile_clay::rviz_plugins
