#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "device/safety_gate.h"

/// Emissions, arrays and gates for the tests of the safety gate.
namespace tactile_clay::device {

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double inf = std::numeric_limits<double>::infinity();

inline ultrasound::FocalPoint point(double x, double y, double z, double intensity = 0.5,
                                    std::uint32_t id = 7) {
  ultrasound::FocalPoint p;
  p.id = id;
  p.position = {x, y, z};
  p.intensity = intensity;
  return p;
}

inline Emission emission(const ultrasound::FocalPoint& p) {
  return {{p}, 200.0};
}

inline Occasion now(double since_last = 1.0) {
  Occasion occasion;
  occasion.since_last = since_last;
  return occasion;
}

using Points = std::vector<ultrasound::FocalPoint>;
using Meter = std::function<Loudness(const Points&)>;

/// An array whose loudness depends on its points only. Each drive is one transducer, whose phase counts the
/// drives that were solved before.
inline Instrument instrument(const Meter& meter) {
  Instrument result;
  result.solve = [solved = 0.0f](const Points& points, const ultrasound::Drive*) mutable {
    ultrasound::PhaseSolution solution;
    solution.drive.phase = {solved++};
    solution.drive.amplitude = {points.empty() ? 0.0f : 1.0f};
    return solution;
  };
  result.loudness = [meter](const ultrasound::Drive&, const Points& points) { return meter(points); };
  return result;
}

/// One that gives 3000 Pa and 120 dB at intensity 1, in proportion to the loudest intensity.
inline Loudness loudness(const Points& points) {
  double strongest = 0.0;
  for (const auto& p : points) strongest = std::max(strongest, p.intensity);
  return {3000.0 * strongest, 120.0 + 20.0 * std::log10(std::max(strongest, 1e-9)), ""};
}

/// An instrument for the rules that do not depend on loudness.
inline Loudness quiet(const Points&) {
  return {0.0, 0.0, ""};
}

inline bool begins(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

/// A gate whose meter can be changed.
class TestGate : public SafetyGate {
 public:
  explicit TestGate(const SafetyGateConfig& config = {}) : TestGate(config, std::make_shared<Meter>(quiet)) {}

  Verdict check(const Emission& e, const Occasion& occasion, const Meter& meter) {
    *meter_ = meter;
    return SafetyGate::check(e, occasion);
  }

 private:
  TestGate(const SafetyGateConfig& config, const std::shared_ptr<Meter>& meter)
      : SafetyGate(config, instrument([meter](const Points& points) { return (*meter)(points); })),
        meter_(meter) {}

  std::shared_ptr<Meter> meter_;
};

class StartedGate : public ::testing::Test {
 protected:
  TestGate gate;
  void SetUp() override { gate.start(); }

  std::string reason(const ultrasound::FocalPoint& p) { return gate.check(emission(p), now(), quiet).reason; }
};

}  // namespace tactile_clay::device
