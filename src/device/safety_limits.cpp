#include "device/safety_limits.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "values/range.h"
#include "values/text.h"

namespace tactile_clay::device {
namespace {

using values::text;

constexpr double farthest = 10.0;  // m, of the corners of a workspace; no array is felt so far away

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
  values::requireAbove("safety gate: stale_timeout (s)", stale_timeout, 0.0);
  for (int axis = 0; axis < 3; ++axis) {
    if (!(low[axis] >= -farthest && high[axis] <= farthest && low[axis] < high[axis]))
      throw std::invalid_argument(std::string("safety gate: workspace in ") + "xyz"[axis] + " is " +
                                  text(low[axis]) + " to " + text(high[axis]) +
                                  ", expected two numbers of m from " + text(-farthest) + " to " +
                                  text(farthest) + ", the lower one first");
  }
  values::requireIn("safety gate: intensity_cap", intensity_cap, 0.0, 1.0);
  values::requireAbove("safety gate: intensity_slew (1/s)", intensity_slew, 0.0);
  values::requireAbove("safety gate: pressure_cap (Pa)", pressure_cap, 0.0);
  if (!std::isfinite(head_spl_cap))
    throw std::invalid_argument("safety gate: head_spl_cap (dB): expected a finite number, got " +
                                text(head_spl_cap));
}

}  // namespace tactile_clay::device
