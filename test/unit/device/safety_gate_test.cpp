#include "device/safety_gate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace tactile_clay::device {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

ultrasound::FocalPoint point(double x, double y, double z, double intensity = 0.5, std::uint32_t id = 7) {
  ultrasound::FocalPoint p;
  p.id = id;
  p.position = {x, y, z};
  p.intensity = intensity;
  return p;
}

Emission emission(const ultrasound::FocalPoint& p) {
  return {{p}, 200.0};
}

class StartedGate : public ::testing::Test {
 protected:
  SafetyGate gate;
  void SetUp() override { gate.start(); }

  std::string reason(const ultrasound::FocalPoint& p) { return gate.check(emission(p), 0.0).reason; }
};

bool begins(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

TEST(SafetyGate, IsClosedUntilItIsStarted) {
  SafetyGate gate;
  EXPECT_TRUE(begins(gate.check(emission(point(0, 0, 0.2)), 0.0).reason, "not started"));
  EXPECT_TRUE(begins(gate.tick(0.0).reason, "not started"));
  gate.start();
  EXPECT_TRUE(gate.check(emission(point(0, 0, 0.2)), 0.0).passes());
  EXPECT_TRUE(gate.tick(0.0).passes());
}

TEST_F(StartedGate, PassesAGoodEmission) {
  EXPECT_EQ(reason(point(0.1, -0.1, 0.2)), "");
  EXPECT_TRUE(gate.check({}, 0.0).passes());
}

TEST_F(StartedGate, SilencesAStaleEmission) {
  const Emission good = emission(point(0, 0, 0.2));
  EXPECT_TRUE(gate.check(good, 0.1).passes());
  EXPECT_EQ(gate.check(good, 0.1001).reason, "stale: focal points are 0.1001 s old, expected at most 0.1 s");
  EXPECT_TRUE(gate.check(good, -0.1).passes());
  EXPECT_FALSE(gate.check(good, -0.1001).passes()) << "a stamp in the future is no fresher";
  EXPECT_FALSE(gate.check(good, nan).passes());
  EXPECT_FALSE(gate.check(good, inf).passes());
  EXPECT_FALSE(gate.check({}, 0.2).passes());
}

TEST_F(StartedGate, TimerSilencesWhenNothingArrives) {
  EXPECT_TRUE(gate.tick(0.1).passes());
  EXPECT_TRUE(begins(gate.tick(0.11).reason, "stale"));
  EXPECT_FALSE(gate.tick(nan).passes());
  gate.stop();
  EXPECT_TRUE(begins(gate.tick(0.0).reason, "emergency stop"));
}

TEST_F(StartedGate, SilencesNonFinitePositions) {
  EXPECT_EQ(reason(point(nan, 0, 0.2)),
            "non-finite: x of focal point 7 is nan, expected a finite number of m");
  EXPECT_TRUE(begins(reason(point(0, inf, 0.2)), "non-finite: y"));
  EXPECT_TRUE(begins(reason(point(0, 0, -inf)), "non-finite: z"));
}

TEST_F(StartedGate, SilencesPointsOutsideTheWorkspace) {
  const double low[] = {-0.20, -0.20, 0.05};
  const double high[] = {0.20, 0.20, 0.40};
  for (int axis = 0; axis < 3; ++axis) {
    auto p = point(0, 0, 0.2);
    p.position[axis] = low[axis];
    EXPECT_EQ(reason(p), "") << "its faces belong to the workspace";
    p.position[axis] = std::nextafter(low[axis], -1.0);
    EXPECT_TRUE(begins(reason(p), std::string("outside the workspace: ") + "xyz"[axis])) << axis;
    p.position[axis] = high[axis];
    EXPECT_EQ(reason(p), "");
    p.position[axis] = std::nextafter(high[axis], 1.0);
    EXPECT_TRUE(begins(reason(p), std::string("outside the workspace: ") + "xyz"[axis])) << axis;
  }
  EXPECT_EQ(reason(point(0, 0, 0.5)),
            "outside the workspace: z of focal point 7 is 0.5 m, expected 0.05 to 0.4 m");
}

TEST_F(StartedGate, SilencesIntensitiesOutOfRange) {
  EXPECT_EQ(reason(point(0, 0, 0.2, 0.0)), "");
  EXPECT_EQ(reason(point(0, 0, 0.2, 1.0)), "");
  EXPECT_TRUE(begins(reason(point(0, 0, 0.2, std::nextafter(1.0, 2.0))), "intensity out of range"));
  EXPECT_TRUE(begins(reason(point(0, 0, 0.2, -1e-9)), "intensity out of range"));
  EXPECT_EQ(reason(point(0, 0, 0.2, 1.5)),
            "intensity out of range: intensity of focal point 7 is 1.5, expected 0 to 1");
  EXPECT_TRUE(begins(reason(point(0, 0, 0.2, nan)), "non-finite: intensity"));
}

TEST(SafetyGate, KeepsToALowerIntensityCap) {
  SafetyGateConfig config;
  config.intensity_cap = 0.6;
  SafetyGate gate(config);
  gate.start();
  EXPECT_TRUE(gate.check(emission(point(0, 0, 0.2, 0.6)), 0.0).passes());
  EXPECT_FALSE(gate.check(emission(point(0, 0, 0.2, 0.61)), 0.0).passes());
}

TEST_F(StartedGate, SilencesTheWholeEmissionForOneUnsafePoint) {
  Emission two = emission(point(0, 0, 0.2, 0.5, 1));
  two.points.push_back(point(0, 0, 0.9, 0.5, 2));
  EXPECT_NE(gate.check(two, 0.0).reason.find("focal point 2"), std::string::npos);
}

TEST_F(StartedGate, SilencesAnImpossibleModulation) {
  Emission e = emission(point(0, 0, 0.2));
  for (const double good : {0.0, 200.0, 1000.0}) {
    e.modulation_frequency = good;
    EXPECT_TRUE(gate.check(e, 0.0).passes()) << good;
  }
  for (const double bad : {-1.0, 1000.1, nan, inf}) {
    e.modulation_frequency = bad;
    EXPECT_TRUE(begins(gate.check(e, 0.0).reason, "modulation")) << bad;
  }
}

TEST(SafetyGate, KeepsToTheLevelAtTheHead) {
  SafetyGateConfig config;
  config.head_spl_cap = 110.0;
  SafetyGate gate(config);
  gate.start();
  const Emission good = emission(point(0, 0, 0.2));
  EXPECT_TRUE(gate.check(good, 0.0, 110.0).passes());
  EXPECT_EQ(gate.check(good, 0.0, 110.5).reason, "head level: 110.5 dB, expected at most 110 dB");
  EXPECT_FALSE(gate.check(good, 0.0, nan).passes());
  EXPECT_EQ(gate.check(good, 0.0).reason, "head level: not known, expected at most 110 dB");
  EXPECT_TRUE(gate.check({}, 0.0).passes()) << "silence is heard nowhere";
}

TEST_F(StartedGate, EmergencyStopHoldsUntilReset) {
  const Emission good = emission(point(0, 0, 0.2));
  gate.stop();
  EXPECT_TRUE(gate.stopped());
  EXPECT_TRUE(begins(gate.check(good, 0.0).reason, "emergency stop"));
  gate.start();
  EXPECT_FALSE(gate.check(good, 0.0).passes()) << "starting does not lift it";
  EXPECT_FALSE(gate.check({}, 0.0).passes());
  gate.reset();
  EXPECT_FALSE(gate.stopped());
  EXPECT_TRUE(gate.check(good, 0.0).passes());
}

TEST(SafetyGate, ResetDoesNotStartIt) {
  SafetyGate gate;
  gate.stop();
  gate.reset();
  EXPECT_TRUE(begins(gate.check(emission(point(0, 0, 0.2)), 0.0).reason, "not started"));
}

TEST(SafetyGate, RefusesBadSettingsByName) {
  const auto message = [](auto change) {
    SafetyGateConfig config;
    change(config);
    try {
      SafetyGate gate(config);
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message([](auto&) {}), "accepted");
  EXPECT_NE(message([](auto& c) { c.stale_timeout = 0.0; }).find("stale_timeout is 0"), std::string::npos);
  EXPECT_NE(message([](auto& c) { c.low.y() = 0.3; }).find("workspace in y is 0.3 to 0.2"),
            std::string::npos);
  EXPECT_NE(message([](auto& c) { c.high.z() = nan; }).find("workspace in z"), std::string::npos);
  EXPECT_NE(message([](auto& c) { c.intensity_cap = 1.1; }).find("intensity_cap is 1.1"), std::string::npos);
  EXPECT_NE(message([](auto& c) { c.head_spl_cap = nan; }).find("head_spl_cap"), std::string::npos);
}

}  // namespace
}  // namespace tactile_clay::device
