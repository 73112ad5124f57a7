#include "device/safety_gate.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace tactile_clay::device {
namespace {

constexpr double max_modulation = 1000.0;  // Hz; nothing is felt above

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

std::string name(const ultrasound::FocalPoint& point) {
  return "focal point " + std::to_string(point.id);
}

/// Empty if all is well with the point.
std::string objection(const ultrasound::FocalPoint& point, const SafetyGateConfig& config) {
  for (int axis = 0; axis < 3; ++axis) {
    const double x = point.position[axis];
    const std::string coordinate = std::string(1, "xyz"[axis]) + " of " + name(point) + " is " + text(x);
    if (!std::isfinite(x)) return "non-finite: " + coordinate + ", expected a finite number of m";
    if (x < config.low[axis] || x > config.high[axis]) {
      return "outside the workspace: " + coordinate + " m, expected " + text(config.low[axis]) + " to " +
             text(config.high[axis]) + " m";
    }
  }
  const std::string intensity = "intensity of " + name(point) + " is " + text(point.intensity);
  if (!std::isfinite(point.intensity)) return "non-finite: " + intensity + ", expected a finite number";
  if (point.intensity < 0.0 || point.intensity > config.intensity_cap) {
    return "intensity out of range: " + intensity + ", expected 0 to " + text(config.intensity_cap);
  }
  return "";
}

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("safety gate: " + what);
}

}  // namespace

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
  require(!head_spl_cap || std::isfinite(*head_spl_cap),
          "head_spl_cap is " + text(head_spl_cap.value_or(0.0)) + ", expected a finite number of dB");
}

SafetyGate::SafetyGate(const SafetyGateConfig& config) : config_(config) {
  config_.validate();
}

Verdict SafetyGate::tick(double age_since_last) const {
  if (stopped_) return {"emergency stop: silent until it is reset"};
  if (!started_) return {"not started: the device is not open yet"};
  // Written so that NaN is stale.
  if (!(age_since_last <= config_.stale_timeout && age_since_last >= -config_.stale_timeout)) {
    return {"stale: focal points are " + text(age_since_last) + " s old, expected at most " +
            text(config_.stale_timeout) + " s"};
  }
  return {};
}

Verdict SafetyGate::check(const Emission& emission, double age, std::optional<double> head_spl) const {
  Verdict verdict = tick(age);
  if (!verdict.passes() || emission.points.empty()) return verdict;
  if (!(emission.modulation_frequency >= 0.0 && emission.modulation_frequency <= max_modulation)) {
    return {"modulation: frequency is " + text(emission.modulation_frequency) + " Hz, expected 0 to " +
            text(max_modulation) + " Hz"};
  }
  for (const ultrasound::FocalPoint& point : emission.points) {
    verdict.reason = objection(point, config_);
    if (!verdict.passes()) return verdict;
  }
  if (config_.head_spl_cap) {
    const double cap = *config_.head_spl_cap;
    if (!head_spl) return {"head level: not known, expected at most " + text(cap) + " dB"};
    if (!(*head_spl <= cap)) {
      return {"head level: " + text(*head_spl) + " dB, expected at most " + text(cap) + " dB"};
    }
  }
  return {};
}

}  // namespace tactile_clay::device
