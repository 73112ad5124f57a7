#pragma once

#include <ros/node_handle.h>

#include <set>
#include <string>

#include "device/safety_limits.h"
#include "device/stamp_check.h"
#include "nodes/settings.h"

namespace tactile_clay::nodes {

/// Rules of the gate that `~gate_without` leaves out. For an array that can hurt somebody no rule may be left
/// out.
/// @throws std::runtime_error with one line if such an array leaves out a rule, std::invalid_argument if a
/// rule is unknown
std::set<device::Rule> rulesLeftOut(const ros::NodeHandle& private_nh, const std::string& device,
                                    bool harmless);

/// Reads the limits of the safety gate that are numbers.
/// @param maximum upper bounds of these limits while the node runs; null at the start
/// @throws std::runtime_error, std::invalid_argument with one line if one is wrong
void readLimits(Settings& settings, device::SafetyGateConfig& config,
                const device::SafetyGateConfig* maximum = nullptr);

/// The settings of the gate that are read at its start only (`~workspace_low`, `~workspace_high`), and the
/// limits that apply if no parameter gives another one. Logs the rules that are left out.
/// @param simulated such an array has no limit of the level at the head unless one is given
/// @throws std::runtime_error with one line if a parameter is wrong
device::SafetyGateConfig gateConfig(const ros::NodeHandle& private_nh, bool simulated,
                                    std::set<device::Rule> without);

/// Reads `~check_stamps`.
/// @throws std::runtime_error with one line if it is wrong
device::StampCheck::Mode stampMode(const ros::NodeHandle& private_nh);

/// Logs the limits of this run, because an earlier run on the same master may have had other limits.
/// @param node name of the node
void tellLimits(const device::SafetyGateConfig& config, const std::string& node);

}  // namespace tactile_clay::nodes
