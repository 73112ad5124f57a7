#include "device/safety_gate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "gates.h"

namespace tactile_clay::device::safety_gate_test {
namespace {

TEST(SafetyGate, IsClosedUntilItIsStarted) {
  TestGate gate;
  EXPECT_TRUE(begins(gate.check(emission(point(0, 0, 0.2)), now(), quiet).reason, "not started"));
  EXPECT_TRUE(begins(gate.tick(0.0).reason, "not started"));
  gate.start();
  EXPECT_TRUE(gate.check(emission(point(0, 0, 0.2)), now(), quiet).passes());
  EXPECT_TRUE(gate.tick(0.0).passes());
}

TEST_F(StartedGate, PassesAGoodEmission) {
  const Verdict verdict = gate.check(emission(point(0.1, -0.1, 0.2)), now(), quiet);
  EXPECT_EQ(verdict.reason, "");
  EXPECT_EQ(verdict.lowered, "");
  ASSERT_EQ(verdict.sound.emission.points.size(), 1u);
  EXPECT_EQ(verdict.sound.emission.points[0].intensity, 0.5);
  EXPECT_EQ(verdict.sound.emission.modulation_frequency, 200.0);
  EXPECT_TRUE(gate.check({}, now(), quiet).passes());
}

TEST_F(StartedGate, SilencesAStaleEmission) {
  const auto passes = [&](double age) {
    Occasion occasion = now();
    occasion.age = age;
    return gate.check(emission(point(0, 0, 0.2)), occasion, quiet).reason;
  };
  EXPECT_EQ(passes(0.1), "");
  EXPECT_EQ(passes(0.1001), "stale: focal points are 0.1001 s old, expected at most 0.1 s");
  EXPECT_EQ(passes(-0.1), "");
  EXPECT_NE(passes(-0.1001), "") << "a stamp in the future is no fresher";
  EXPECT_NE(passes(nan), "");
  EXPECT_NE(passes(inf), "");
  Occasion old = now();
  old.age = 0.2;
  EXPECT_FALSE(gate.check({}, old, quiet).passes());
}

TEST_F(StartedGate, TimerSilencesWhenNothingArrives) {
  EXPECT_TRUE(gate.tick(0.1).passes());
  EXPECT_TRUE(begins(gate.tick(0.11).reason, "stale"));
  EXPECT_FALSE(gate.tick(nan).passes());
  gate.stop();
  EXPECT_TRUE(begins(gate.tick(0.0).reason, "emergency stop"));
}

TEST_F(StartedGate, SilencesWhatNoHandCanFeel) {
  Occasion occasion = now();
  occasion.hands_age = 0.1;
  EXPECT_TRUE(gate.check(emission(point(0, 0, 0.2)), occasion, quiet).passes());
  occasion.hands_age = 0.11;
  EXPECT_EQ(gate.check(emission(point(0, 0, 0.2)), occasion, quiet).reason,
            "hand lost: no word of the hands for 0.11 s, expected one every 0.1 s");
  occasion.hands_age = nan;
  EXPECT_FALSE(gate.check(emission(point(0, 0, 0.2)), occasion, quiet).passes());
  occasion.hands_age = 0.0;
  occasion.hands_tracked = false;
  EXPECT_TRUE(begins(gate.check(emission(point(0, 0, 0.2)), occasion, quiet).reason, "hand lost"));
  EXPECT_TRUE(gate.check({}, occasion, quiet).passes()) << "silence needs no hand";
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
  TestGate gate(config);
  gate.start();
  EXPECT_TRUE(gate.check(emission(point(0, 0, 0.2, 0.6)), now(), quiet).passes());
  EXPECT_FALSE(gate.check(emission(point(0, 0, 0.2, 0.61)), now(), quiet).passes());
}

TEST_F(StartedGate, SilencesTheWholeEmissionForOneUnsafePoint) {
  Emission two = emission(point(0, 0, 0.2, 0.5, 1));
  two.points.push_back(point(0, 0, 0.9, 0.5, 2));
  const Verdict verdict = gate.check(two, now(), quiet);
  EXPECT_NE(verdict.reason.find("focal point 2"), std::string::npos);
  EXPECT_TRUE(verdict.sound.emission.points.empty());
}

TEST_F(StartedGate, SilencesAnImpossibleModulation) {
  Emission e = emission(point(0, 0, 0.2));
  for (const double good : {0.0, 200.0, 1000.0}) {
    e.modulation_frequency = good;
    EXPECT_TRUE(gate.check(e, now(), quiet).passes()) << good;
  }
  for (const double bad : {-1.0, 1000.1, nan, inf}) {
    e.modulation_frequency = bad;
    EXPECT_TRUE(begins(gate.check(e, now(), quiet).reason, "modulation")) << bad;
  }
}

// Slip lowers the amplitude at some times and never raises it: the drives are judged at their full amplitude.
TEST_F(StartedGate, SlipIsAShareAndMakesNothingLouder) {
  Emission e = emission(point(0, 0, 0.2, 1.0));
  for (const double bad : {-0.1, 1.1, nan, inf}) {
    e.slip = bad;
    EXPECT_TRUE(begins(gate.check(e, now(), quiet).reason, "modulation: slip")) << bad;
  }
  for (const double good : {0.0, 0.4, 1.0}) {
    e.slip = good;
    const Verdict verdict = gate.check(e, now(), loudness);
    ASSERT_TRUE(verdict.passes()) << verdict.reason;
    EXPECT_EQ(verdict.sound.emission.slip, good);
    EXPECT_LE(3000.0 * verdict.sound.emission.points[0].intensity, 2000.0);
    ASSERT_EQ(verdict.sound.parts.size(), 1u);
    EXPECT_NEAR(verdict.sound.parts[0].what.power, 0.5, 1e-12) << "(1 - cos) / 2 and slip leave half alike";
  }
}

TEST_F(StartedGate, LetsIntensityRiseNoFasterThanTheSlew) {
  const auto passed = [&](double intensity, double since_last, std::uint32_t id = 7) {
    const Verdict verdict = gate.check(emission(point(0, 0, 0.2, intensity, id)), now(since_last), quiet);
    EXPECT_TRUE(verdict.passes());
    return verdict.sound.emission.points.at(0).intensity;
  };
  EXPECT_DOUBLE_EQ(passed(1.0, 0.01), 0.2) << "20 a second, from 0 for a new point";
  EXPECT_DOUBLE_EQ(passed(1.0, 0.01), 0.4);
  EXPECT_DOUBLE_EQ(passed(0.1, 0.01), 0.1) << "it may fall at once";
  EXPECT_DOUBLE_EQ(passed(1.0, 0.01), 0.3);
  EXPECT_DOUBLE_EQ(passed(1.0, 0.01, 8), 0.2) << "another point starts from 0";
  EXPECT_DOUBLE_EQ(passed(1.0, -5.0, 8), 0.2) << "time that runs backwards gives no rise";
  EXPECT_DOUBLE_EQ(passed(1.0, nan, 8), 0.2);
  EXPECT_DOUBLE_EQ(passed(1.0, 5.0, 8), 1.0);
  gate.stop();
  gate.reset();
  EXPECT_DOUBLE_EQ(passed(1.0, 0.01, 8), 0.2) << "after a stop it starts from 0";
  gate.fallSilent();
  EXPECT_DOUBLE_EQ(passed(1.0, 0.01, 8), 0.2) << "and after any other silence";
}

TEST(SafetyGate, ALongPauseIsNoReasonToJump) {
  SafetyGateConfig config;
  config.intensity_slew = 2.0;
  TestGate gate(config);
  gate.start();
  const Verdict verdict = gate.check(emission(point(0, 0, 0.2, 1.0)), now(60.0), quiet);
  ASSERT_EQ(verdict.sound.emission.points.size(), 1u);
  EXPECT_DOUBLE_EQ(verdict.sound.emission.points[0].intensity, 0.2) << "0.1 s of rise at most";
}

TEST_F(StartedGate, PointsOfEqualIdAreEachTheirOwn) {
  const auto both = [](double first, double second) {
    return Emission{{point(-0.03, 0, 0.2, first, 0), point(0.03, 0, 0.2, second, 0)}, 200.0};
  };
  const auto passed = [&](double first, double second) {
    const Verdict verdict = gate.check(both(first, second), now(0.01), quiet);
    std::vector<double> intensities;
    for (const auto& p : verdict.sound.emission.points) intensities.push_back(p.intensity);
    return intensities;
  };
  EXPECT_EQ(passed(0.1, 0.9), (std::vector<double>{0.1, 0.2}));
  EXPECT_EQ(passed(0.9, 0.15), (std::vector<double>{0.1 + 0.2, 0.15})) << "each rises from its own";
  EXPECT_EQ(
      gate.check(emission(point(0.03, 0, 0.2, 0.9, 0)), now(0.01), quiet).sound.emission.points[0].intensity,
      0.1 + 0.2 + 0.2);
}

TEST_F(StartedGate, EmergencyStopHoldsUntilReset) {
  const Emission good = emission(point(0, 0, 0.2));
  gate.stop();
  EXPECT_TRUE(gate.stopped());
  EXPECT_TRUE(begins(gate.check(good, now(), quiet).reason, "emergency stop"));
  gate.start();
  EXPECT_FALSE(gate.check(good, now(), quiet).passes()) << "starting does not lift it";
  EXPECT_FALSE(gate.check({}, now(), quiet).passes());
  gate.reset();
  EXPECT_FALSE(gate.stopped());
  EXPECT_TRUE(gate.check(good, now(), quiet).passes());
}

TEST(SafetyGate, ResetDoesNotStartIt) {
  TestGate gate;
  gate.stop();
  gate.reset();
  EXPECT_TRUE(begins(gate.check(emission(point(0, 0, 0.2)), now(), quiet).reason, "not started"));
}

}  // namespace
}  // namespace tactile_clay::device::safety_gate_test
