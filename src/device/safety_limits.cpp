#include "device/safety_limits.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "values/text.h"

namespace tactile_clay::device {
namespace {

using values::text;

constexpr std::pair<Rule, const char*> names[] = {{Rule::emergency_stop, "emergency_stop"},
                                                  {Rule::not_started, "not_started"},
                                                  {Rule::stale, "stale"},
                                                  {Rule::hand_lost, "hand_lost"},
                                                  {Rule::modulation, "modulation"},
                                                  {Rule::non_finite, "non_finite"},
                                                  {Rule::workspace, "workspace"},
                                                  {Rule::intensity, "intensity"},
                                                  {Rule::slew, "slew"},
                                                  {Rule::pressure, "pressure"},
                                                  {Rule::head_level, "head_level"}};

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("safety gate: " + what);
}

}  // namespace

std::string nameOf(Rule rule) {
  for (const auto& [known, name] : names)
    if (known == rule) return name;
  return "";
}

Rule ruleOf(const std::string& name) {
  std::string list;
  for (const auto& [rule, known] : names) {
    if (name == known) return rule;
    list += (list.empty() ? "" : ", ") + std::string(known);
  }
  throw std::invalid_argument("safety gate: unknown rule '" + name + "', expected one of " + list);
}

void SafetyGateConfig::validate() const {
  require(std::isfinite(stale_timeout) && stale_timeout > 0.0,
          "stale_timeout is " + text(stale_timeout) + ", expected a positive number of s");
  for (int axis = 0; axis < 3; ++axis) {
    require(std::isfinite(low[axis]) && std::isfinite(high[axis]) && low[axis] < high[axis],
            std::string("workspace in ") + "xyz"[axis] + " is " + text(low[axis]) + " to " +
                text(high[axis]) + ", expected two finite numbers of m, the lower one first");
  }
  require(intensity_cap >= 0.0 && intensity_cap <= 1.0,
          "intensity_cap is " + text(intensity_cap) + ", expected 0 to 1");
  require(std::isfinite(intensity_slew) && intensity_slew > 0.0,
          "intensity_slew is " + text(intensity_slew) + ", expected a positive number of 1/s");
  require(std::isfinite(pressure_cap) && pressure_cap > 0.0,
          "pressure_cap is " + text(pressure_cap) + ", expected a positive number of Pa");
  require(std::isfinite(head_spl_cap),
          "head_spl_cap is " + text(head_spl_cap) + ", expected a finite number of dB");
}

}  // namespace tactile_clay::device
