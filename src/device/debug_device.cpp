#include "device/debug_device.h"

#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <utility>

namespace tactile_clay::device {
namespace {

/// Hz; 0: no lines
double logRate(const std::map<std::string, std::string>& options) {
  const auto given = options.find("log_rate");
  if (given == options.end() || given->second.empty()) return 1.0;
  const std::string& text = given->second;
  try {
    std::size_t end = 0;
    const double rate = std::stod(text, &end);
    if (end == text.size() && std::isfinite(rate) && rate >= 0.0) return rate;
  } catch (const std::exception&) {
    // The error below names what was expected.
  }
  throw std::runtime_error("debug array: log_rate is '" + text + "', expected 0 or a positive number of Hz");
}

std::string describe(const Emission& emission) {
  if (emission.points.empty()) return "debug array: silence";
  char buffer[160];
  std::snprintf(buffer, sizeof buffer, "debug array: %zu points at %g Hz %s:", emission.points.size(),
                emission.modulation_frequency, ultrasound::nameOf(emission.modulation));
  std::string line = buffer;
  if (emission.slip > 0.0) {
    std::snprintf(buffer, sizeof buffer, " slip %.2f,", emission.slip);
    line += buffer;
  }
  for (const auto& point : emission.points) {
    std::snprintf(buffer, sizeof buffer, " [%u] (%.4f %.4f %.4f) m", point.id, point.position.x(),
                  point.position.y(), point.position.z());
    line += buffer;
    std::snprintf(buffer, sizeof buffer, " %.0f Pa intensity %.3f", point.pressure, point.intensity);
    line += buffer;
  }
  return line;
}

}  // namespace

DebugDevice::DebugDevice()
    : DebugDevice(
          [](const std::string& line) { std::cerr << line << '\n'; },
          [] { return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()); }) {}

DebugDevice::DebugDevice(Sink sink, Clock clock) : sink_(std::move(sink)), clock_(std::move(clock)) {}

void DebugDevice::requireOptions(const std::map<std::string, std::string>& options) const {
  logRate(options);
}

void DebugDevice::open(const std::map<std::string, std::string>& options) {
  const double rate = logRate(options);
  quiet_ = rate == 0.0;
  interval_ = std::chrono::nanoseconds(quiet_ ? 0 : std::llround(std::min(1e9 / rate, 1e18)));
  said_any_ = false;
  open_ = true;
  sink_("debug array: open");
}

Capabilities DebugDevice::capabilities() const {
  using ultrasound::Modulation;
  Capabilities capabilities;
  capabilities.modulations = {Modulation::amplitude, Modulation::lateral, Modulation::spatiotemporal,
                              Modulation::field,     Modulation::circle,  Modulation::field_circle};
  capabilities.slip = true;
  return capabilities;
}

void DebugDevice::submit(const Sound& sound) {
  const Emission& emission = sound.emission;
  if (!open_) throw std::runtime_error("debug array: emission before it was opened");
  ++submissions_;
  emitting_ = !emission.points.empty();
  if (quiet_) return;
  const std::chrono::nanoseconds now = clock_();
  if (said_any_ && now - last_line_ < interval_) return;
  said_any_ = true;
  last_line_ = now;
  sink_(describe(emission));
}

void DebugDevice::stop() noexcept {
  ++stops_;
  const bool was_emitting = std::exchange(emitting_, false);
  if (!was_emitting) return;
  try {
    sink_("debug array: stopped after " + std::to_string(submissions_) + " emissions");
  } catch (const std::exception&) {
    // If the sink fails, the array has to fall silent all the same.
  }
}

std::string DebugDevice::fault() const {
  return open_ ? "" : "not open";
}

}  // namespace tactile_clay::device
