#pragma once

#include <Eigen/Core>
#include <array>
#include <set>
#include <string>

#include "safety/silence_times.h"

namespace tactile_clay::device {

/// What the gate looks at.
enum class Rule {
  emergency_stop,
  not_started,
  stale,
  hand_lost,
  modulation,
  non_finite,
  workspace,
  intensity,
  slew,
  pressure,
  head_level
};

/// Name of a rule, such as "hand_lost"; the rule of a name.
/// @throws std::invalid_argument listing the names
std::string nameOf(Rule rule);
Rule ruleOf(const std::string& name);

struct SafetyGateConfig {
  /// s, of focal points and of hands
  double stale_timeout = silence_times::seconds(silence_times::stale);
  Eigen::Vector3d low{-0.20, -0.20, 0.05};  // corners of the workspace, m, frame of the array
  Eigen::Vector3d high{0.20, 0.20, 0.40};   // its faces belong to it
  double intensity_cap = 1.0;               // at most 1
  double intensity_slew = 20.0;             // 1/s, rise of a point's intensity
  double pressure_cap = 2000.0;             // Pa, peak acoustic pressure anywhere in the workspace
  double head_spl_cap = 110.0;              // dB re 20 uPa rms at the head, unmodulated
  std::set<Rule> without;                   // rules that are left out; for arrays that are not there

  /// @throws std::invalid_argument naming the parameter, its value and its range
  void validate() const;
};

/// A limit of the gate that is a number: smaller is stricter.
struct Limit {
  const char* name;
  double SafetyGateConfig::*value;
  double low, high;  // where it may lie
  const char* meaning;
};
inline constexpr std::array<Limit, 5> limits = {{
    {"stale_timeout", &SafetyGateConfig::stale_timeout, 0.001, 10.0, "s, without focal points or hands"},
    {"intensity_cap", &SafetyGateConfig::intensity_cap, 0.0, 1.0,
     "intensity of a point: more silences the array"},
    {"intensity_slew", &SafetyGateConfig::intensity_slew, 0.001, 1e6, "1/s, rise of a point's intensity"},
    {"pressure_cap", &SafetyGateConfig::pressure_cap, 1.0, 1e6, "Pa, peak anywhere in the workspace"},
    {"head_spl_cap", &SafetyGateConfig::head_spl_cap, 0.0, 200.0,
     "dB re 20 uPa rms at the head, unmodulated"},
}};

}  // namespace tactile_clay::device
