#pragma once

#include <ros/node_handle.h>

#include <set>
#include <string>

#include "device/safety_limits.h"
#include "device/stamp_check.h"
#include "nodes/settings.h"

namespace tactile_clay::nodes {

/// Rules of the gate that `~gate_without` leaves out. An array that can hurt somebody has none:
/// @throws std::runtime_error with one line then, and std::invalid_argument for a rule that is unknown
std::set<device::Rule> rulesLeftOut(const ros::NodeHandle& private_nh, const std::string& device,
                                    bool harmless);

/// The numbers of the safety gate's limits.
/// @param maximum that they may be now
/// @throws std::runtime_error, std::invalid_argument with one line where one is wrong
void readLimits(Settings& settings, device::SafetyGateConfig& config,
                const device::SafetyGateConfig* maximum = nullptr);

/// What of the gate is set at its start alone (`~workspace_low`, `~workspace_high`), and the limits where no
/// parameter says another; tells of rules that are left out.
/// @param simulated such an array keeps to no level at the head unless one is given
/// @throws std::runtime_error with one line where a parameter is wrong
device::SafetyGateConfig gateConfig(const ros::NodeHandle& private_nh, bool simulated,
                                    std::set<device::Rule> without);

/// `~check_stamps`.
/// @throws std::runtime_error with one line where it is wrong
device::StampCheck::Mode stampMode(const ros::NodeHandle& private_nh);

/// Tells what a run keeps to: an earlier one on the same master may have had other limits.
/// @param node whose
void tellLimits(const device::SafetyGateConfig& config, const std::string& node);

}  // namespace tactile_clay::nodes
