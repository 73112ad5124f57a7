// The rows of the table of live parameters, and what is asked of a node from one.
#include "rviz_plugins/live_values.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "nodes/live_parameters.h"
#include "nodes/named_value.h"
#include "support/error_of.h"

namespace tactile_clay::rviz_plugins {
namespace {

using dynamic_reconfigure::Config;

Config numbers(int whole, double number, double other) {
  Config config;
  config.ints.push_back(nodes::namedValue<dynamic_reconfigure::IntParameter>("max_points", whole));
  config.doubles.push_back(nodes::namedValue<dynamic_reconfigure::DoubleParameter>("wax/viscosity", number));
  config.doubles.push_back(nodes::namedValue<dynamic_reconfigure::DoubleParameter>("tolerance", other));
  return config;
}

void describe(dynamic_reconfigure::ConfigDescription& all, const char* name, const char* type,
              const char* method = "") {
  dynamic_reconfigure::ParamDescription told;
  told.name = name;
  told.type = type;
  told.description = std::string("meaning of ") + name;
  told.edit_method = method;
  all.groups.back().parameters.push_back(told);
}

dynamic_reconfigure::ConfigDescription description() {
  constexpr double any = std::numeric_limits<double>::infinity();
  dynamic_reconfigure::ConfigDescription all;
  all.groups.resize(1);
  describe(all, "max_points", "int");
  describe(all, "tolerance", "double");
  describe(all, "sleeping", "bool");
  describe(
      all, "modulation", "str",
      "{'enum': [{'name': 'am', 'type': 'str', 'value': 'am', 'description': ''}, {'name': 'stm', 'type': "
      "'str', 'value': 'stm', 'description': ''}], 'enum_description': ''}");
  describe(all, "grade", "int", "{'enum': [{'name': 'low', 'value': 0}, {'name': 'high', 'value': 12}]}");
  all.groups.resize(2);
  describe(all, "wax/viscosity", "double");
  all.min = numbers(1, 0.0, -any);
  all.max = numbers(256, 1e6, any);
  all.dflt = numbers(8, 150.5, 0.25);
  return all;
}

TEST(LiveValues, RowsAreTheParametersOfAllGroupsInTheirOrder) {
  Config values = numbers(5, 100.0, 1e-4);
  values.bools.push_back(nodes::namedValue<dynamic_reconfigure::BoolParameter>("sleeping", true));
  values.strs.push_back(nodes::namedValue<dynamic_reconfigure::StrParameter>("another", "text"));
  const auto rows = liveParameters(description(), values);
  ASSERT_EQ(rows.size(), 6u);
  EXPECT_EQ(rows[0].now.name, "max_points");
  EXPECT_EQ(rows[0].now.type, "int");
  EXPECT_EQ(rows[0].now.text, "5");
  EXPECT_EQ(rows[0].low, "1");
  EXPECT_EQ(rows[0].high, "256");
  EXPECT_EQ(rows[0].fallback, "8");
  EXPECT_EQ(rows[0].meaning, "meaning of max_points");
  EXPECT_TRUE(rows[0].choices.empty());
  EXPECT_EQ(rows[1].now.text, "0.0001");
  EXPECT_EQ(rows[1].low + rows[1].high, "") << "no limits";
  EXPECT_EQ(rows[2].now.text, "true");
  EXPECT_EQ(rows[2].choices, (std::vector<std::string>{"true", "false"}));
  EXPECT_EQ(rows[3].now.text, "") << "not known yet";
  EXPECT_EQ(rows[3].choices, (std::vector<std::string>{"am", "stm"}));
  EXPECT_EQ(rows[4].choices, (std::vector<std::string>{"0", "12"}));
  EXPECT_EQ(rows[5].now.name, "wax/viscosity");
  EXPECT_EQ(rows[5].high, "1e+06");
}

TEST(LiveValues, TornChoicesAreLeftOut) {
  dynamic_reconfigure::ConfigDescription all;
  all.groups.resize(1);
  describe(all, "modulation", "str", "{'enum': [{'value': 'am', 'name': ''}, {'value': 'st");
  EXPECT_EQ(liveParameters(all, Config())[0].choices, (std::vector<std::string>{"am"}));
}

TEST(LiveValues, ARequestHasOneValueOfTheType) {
  Config config = configOf({"wax/viscosity", "double", " 2.5e2 "});
  ASSERT_EQ(config.doubles.size(), 1u);
  EXPECT_EQ(config.doubles[0].name, "wax/viscosity");
  EXPECT_EQ(config.doubles[0].value, 250.0);
  EXPECT_EQ(config.ints.size() + config.bools.size() + config.strs.size(), 0u);
  config = configOf({"max_points", "int", "-3"});
  ASSERT_EQ(config.ints.size(), 1u);
  EXPECT_EQ(config.ints[0].value, -3);
  EXPECT_EQ(textOf(config, "max_points"), "-3");
  EXPECT_EQ(textOf(config, "min_points"), "");
  config = configOf({"sleeping", "bool", "false"});
  ASSERT_EQ(config.bools.size(), 1u);
  EXPECT_EQ(config.bools[0].value, 0);
  config = configOf({"solver", "str", ""});
  ASSERT_EQ(config.strs.size(), 1u);
  EXPECT_EQ(config.strs[0].value, "");
}

TEST(LiveValues, WhatIsNoValueIsToldInOneLine) {
  const auto error = [](const char* type, const char* text) {
    return errorOf([&] { configOf({"x", type, text}); });
  };
  EXPECT_EQ(error("double", "soft"), "x: expected a number, got 'soft'");
  EXPECT_EQ(error("double", "1 2"), "x: expected a number, got '1 2'");
  EXPECT_EQ(error("double", ""), "x: expected a number, got ''");
  EXPECT_EQ(error("int", "1.5"), "x: expected a whole number, got '1.5'");
  EXPECT_EQ(error("int", "3e9"), "x: expected a whole number, got '3e9'");
  EXPECT_EQ(error("bool", "yes"), "x: expected true or false, got 'yes'");
}

TEST(LiveValues, ARefusalIsFoundInTheLog) {
  const std::string begin = std::string("/rig/clay_simulator") + nodes::no_change;
  EXPECT_EQ(refusalIn(begin + "too soft", "/rig/clay_simulator"), "too soft");
  EXPECT_EQ(refusalIn(begin + "too soft", "/clay_simulator"), "");
  EXPECT_EQ(refusalIn(begin + "too soft", ""), "");
  EXPECT_EQ(refusalIn("/rig/clay_simulator: late", "/rig/clay_simulator"), "");
}

TEST(LiveValues, NodesAreKnownByTheTopicOfTheirDescription) {
  const std::string type = "dynamic_reconfigure/ConfigDescription";
  EXPECT_EQ(liveNodeOf("/clay/parameter_descriptions", type, "/"), "/clay");
  EXPECT_EQ(liveNodeOf("/left/clay/parameter_descriptions", type, "/left"), "/left/clay");
  EXPECT_EQ(liveNodeOf("/leftmost/clay/parameter_descriptions", type, "/left"), "");
  EXPECT_EQ(liveNodeOf("/clay/parameter_updates", "dynamic_reconfigure/Config", "/"), "");
  EXPECT_EQ(liveNodeOf("/clay/parameter_descriptions", "std_msgs/String", "/"), "");
  EXPECT_EQ(liveNodeOf("/parameter_descriptions", type, "/"), "");
}

}  // namespace
}  // namespace tactile_clay::rviz_plugins
