#include "device/safety_gate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/phase_solver.h"

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

Occasion now(double since_last = 1.0) {
  Occasion occasion;
  occasion.since_last = since_last;
  return occasion;
}

using Points = std::vector<ultrasound::FocalPoint>;
using Meter = std::function<Loudness(const Points&)>;

/// An array whose loudness depends on its points only. Each drive is one transducer, whose phase counts the
/// drives that were solved before.
Instrument instrument(const Meter& meter) {
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

Loudness loudness(const Points& points) {
  double strongest = 0.0;
  for (const auto& p : points) strongest = std::max(strongest, p.intensity);
  return {3000.0 * strongest, 120.0 + 20.0 * std::log10(std::max(strongest, 1e-9)), ""};
}

/// An instrument for the rules that do not depend on loudness.
Loudness quiet(const Points&) {
  return {0.0, 0.0, ""};
}

bool begins(const std::string& text, const std::string& start) {
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

TEST(SafetyGate, IsTightenedWhileItRunsAndNeverMadeLessStrict) {
  SafetyGateConfig config;
  config.pressure_cap = 1500.0;
  const auto of = [](double cap) {  // an instrument that tells a cap as its loudness
    return instrument([cap](const Points&) { return Loudness{cap, 0.0, ""}; });
  };
  SafetyGate gate(config, of(1500.0));
  gate.start();
  SafetyGateConfig stricter = config;
  stricter.pressure_cap = 1000.0;
  stricter.stale_timeout = 0.05;
  gate.tighten(stricter, of(1000.0));
  EXPECT_EQ(gate.config().pressure_cap, 1000.0);
  EXPECT_FALSE(gate.tick(0.06).passes());
  EXPECT_TRUE(gate.check(emission(point(0, 0, 0.2)), now()).passes());  // by the new instrument
  gate.tighten(config, of(1500.0));                                     // as at the start
  EXPECT_TRUE(gate.tick(0.06).passes());
  for (const Limit& limit : limits) {
    SafetyGateConfig half = config;
    half.*limit.value *= 0.5;
    SafetyGate strict(half, of(1500.0));
    try {
      strict.tighten(config, of(1500.0));
      FAIL() << limit.name;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(limit.name), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("never made less strict"), std::string::npos) << error.what();
    }
    EXPECT_EQ(strict.config().*limit.value, half.*limit.value);
  }
  SafetyGateConfig wider = config;
  wider.high.z() += 0.1;
  EXPECT_THROW(gate.tighten(wider, of(1500.0)), std::invalid_argument);
  SafetyGateConfig without = config;
  without.without = {Rule::hand_lost};
  EXPECT_THROW(gate.tighten(without, of(1500.0)), std::invalid_argument);
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

TEST_F(StartedGate, LowersWhatIsTooLoud) {
  // 3000 Pa and 120 dB at intensity 1; caps 2000 Pa and 110 dB, which is 0.316 of 120 dB.
  const Verdict verdict = gate.check(emission(point(0, 0, 0.2, 1.0)), now(), loudness);
  EXPECT_EQ(verdict.reason, "");
  EXPECT_TRUE(begins(verdict.lowered, "head level")) << verdict.lowered;
  EXPECT_LE(*loudness(verdict.sound.emission.points).head, 110.0);
  EXPECT_NEAR(verdict.sound.emission.points[0].intensity, 0.316, 0.004);
  EXPECT_DOUBLE_EQ(*verdict.head_spl, *loudness(verdict.sound.emission.points).head);

  SafetyGateConfig config;
  config.head_spl_cap = 200.0;
  TestGate pressure_only(config);
  pressure_only.start();
  Emission two = emission(point(0, 0, 0.2, 1.0, 1));
  two.points.push_back(point(0.05, 0, 0.2, 0.5, 2));
  const Verdict capped = pressure_only.check(two, now(), loudness);
  EXPECT_TRUE(begins(capped.lowered, "pressure: 3000 Pa")) << capped.lowered;
  EXPECT_LE(*loudness(capped.sound.emission.points).pressure, 2000.0);
  EXPECT_NEAR(capped.sound.emission.points[0].intensity, 2.0 / 3.0, 0.01);
  EXPECT_DOUBLE_EQ(capped.sound.emission.points[1].intensity, 0.5 * capped.sound.emission.points[0].intensity)
      << "all are lowered together";
}

/// Boards that switch channels off get quieter in steps: just above the cap, a slightly lower intensity
/// changes nothing.
TEST_F(StartedGate, LowersAnArrayThatGoesDownInSteps) {
  const auto steps = [](const Points& points) {
    return Loudness{0.0, 110.1 + 20.0 * std::log10(std::ceil(4.0 * points[0].intensity) / 3.0), ""};
  };
  const Verdict verdict = gate.check(emission(point(0, 0, 0.2, 0.75)), now(), steps);
  EXPECT_EQ(verdict.reason, "");
  ASSERT_EQ(verdict.sound.emission.points.size(), 1u);
  EXPECT_LE(verdict.sound.emission.points[0].intensity, 0.5);
  EXPECT_GT(verdict.sound.emission.points[0].intensity, 0.25) << "no lower than it has to be";
  EXPECT_NEAR(verdict.head_spl.value(), 110.1 + 20.0 * std::log10(2.0 / 3.0), 1e-9);
}

TEST_F(StartedGate, SilencesWhatCannotBeMeasuredOrLowered) {
  const Emission good = emission(point(0, 0, 0.2));
  const auto reason = [&](const Loudness& loudness) {
    return gate.check(good, now(), [&](const Points&) { return loudness; }).reason;
  };
  EXPECT_EQ(reason({1.0, std::nullopt, ""}), "head level: not known, expected at most 110 dB");
  EXPECT_EQ(reason({std::nullopt, 1.0, ""}), "pressure: not known, expected at most 2000 Pa");
  EXPECT_EQ(reason({1.0, 111.0, ""}), "head level: 111 dB, expected at most 110 dB") << "however weak";
  EXPECT_EQ(reason({2001.0, 1.0, ""}), "pressure: 2001 Pa, expected at most 2000 Pa");
  EXPECT_TRUE(begins(reason({nan, 1.0, ""}), "pressure"));
  EXPECT_TRUE(begins(reason({1.0, nan, ""}), "head level"));
  EXPECT_EQ(reason({2000.0, 110.0, ""}), "");
}

TEST_F(StartedGate, LooksAtEveryInstantOfAModulation) {
  using ultrasound::Modulation;
  // A point within the workspace, which lateral modulation takes 3 mm out of it.
  Emission edge = emission(point(0.199, 0, 0.2));
  EXPECT_TRUE(gate.check(edge, now(), quiet).passes());
  edge.modulation = Modulation::lateral;
  edge.modulation_frequency = 10.0;
  EXPECT_TRUE(begins(gate.check(edge, now(), quiet).reason, "outside the workspace: x of focal point 7"));
  edge.points[0].position.x() = 0.1969;
  const Verdict passed = gate.check(edge, now(), quiet);
  EXPECT_EQ(passed.reason, "");
  EXPECT_EQ(passed.sound.emission.modulation, Modulation::lateral);
  EXPECT_EQ(passed.sound.emission.modulation_frequency, 10.0);
  edge.modulation_frequency = 0.0;
  EXPECT_TRUE(begins(gate.check(edge, now(), quiet).reason, "modulation: frequency is 0 Hz"));
  // A circle takes it out along x, and another one along y.
  edge.modulation = Modulation::circle;
  edge.modulation_frequency = 5.0;
  EXPECT_EQ(gate.check(edge, now(), quiet).reason, "");
  edge.points[0].position.x() = 0.1971;
  EXPECT_TRUE(begins(gate.check(edge, now(), quiet).reason, "outside the workspace: x of focal point 7"));
  edge.points[0].position = {0, -0.1971, 0.2};
  EXPECT_TRUE(begins(gate.check(edge, now(), quiet).reason, "outside the workspace: y of focal point 7"));
  // And to one place where it is too loud.
  edge.points[0].position = {0, 0, 0.2};
  const Verdict weaker = gate.check(edge, now(), [](const Points& points) {
    return Loudness{(points.at(0).position.x() > 0.0029 ? 8000.0 : 100.0) * points[0].intensity, 0.0, ""};
  });
  EXPECT_EQ(weaker.reason, "");
  EXPECT_LE(8000.0 * weaker.sound.emission.points[0].intensity, 2000.0);
  EXPECT_EQ(weaker.sound.parts.size(), ultrasound::circle_steps);

  // A path with one place that is too loud: the meter judges each place by itself, and all become weaker.
  Emission path{{point(0.0, 0, 0.2, 0.4, 0), point(0.02, 0, 0.2, 0.9, 1), point(0.04, 0, 0.2, 0.5, 2)},
                100.0,
                Modulation::spatiotemporal};
  std::size_t maximum = 0;
  const auto meter = [&maximum](const Points& points) {
    maximum = std::max(maximum, points.size());
    return Loudness{4000.0 * points.at(0).intensity, 0.0, ""};
  };
  const Verdict lowered = gate.check(path, now(), meter);
  ASSERT_EQ(lowered.reason, "");
  EXPECT_EQ(maximum, 1u);
  EXPECT_LE(4000.0 * lowered.sound.emission.points[1].intensity, 2000.0);
  EXPECT_NEAR(lowered.sound.emission.points[1].intensity / lowered.sound.emission.points[0].intensity,
              0.9 / 0.4, 1e-9);
  EXPECT_TRUE(begins(lowered.lowered, "pressure"));
  // If the loudness of one place is unknown or not a number, the array is silent, whichever place it is.
  for (const std::size_t bad : {0u, 1u, 2u}) {
    for (const std::optional<double> what : {std::optional<double>(), std::optional<double>(nan)}) {
      const auto part = [&](const Points& points) {
        return points[0].id == bad ? Loudness{what, 0.0, ""} : Loudness{100.0, 0.0, ""};
      };
      EXPECT_TRUE(begins(gate.check(path, now(), part).reason, "pressure")) << bad;
    }
  }
  path.points[2].position.y() = 0.5;
  EXPECT_TRUE(begins(gate.check(path, now(), quiet).reason, "outside the workspace: y of focal point 2"));
  path.points[2].position.y() = 0.0;
  // The slew limits each place.
  ASSERT_TRUE(gate.check(path, now(), quiet).passes());
  path.points[0].intensity = 0.9;
  EXPECT_NEAR(gate.check(path, now(0.01), quiet).sound.emission.points[0].intensity, 0.6, 1e-9);
}

/// The rules for loudness with the field of a real drive, measured again by another formula: 20 log10 of the
/// rms over 20 uPa.
TEST_F(StartedGate, KeepsARealArrayBelowItsCaps) {
  const auto layout = ultrasound::arrayLayout("usx");
  const ultrasound::Acoustics air;
  const Eigen::Vector3d head(-0.4, 0, 0.6);
  const auto meter = [&](const Points& points) {
    const auto drive = ultrasound::solvePhases(layout, air, points).drive;
    double focus = 0.0;
    for (const auto& p : points)
      focus = std::max(focus, std::abs(ultrasound::pressureAt(layout, air, drive, p.position)));
    return Loudness{focus, ultrasound::headSpl(layout, air, drive, head), ""};
  };
  const Emission loud = emission(point(-0.02, 0, 0.15, 1.0));
  EXPECT_GT(*meter(loud.points).pressure, 4000.0);
  EXPECT_GT(*meter(loud.points).head, 110.0);
  const Verdict verdict = gate.check(loud, now(), meter);
  ASSERT_EQ(verdict.reason, "");
  const auto drive = ultrasound::solvePhases(layout, air, verdict.sound.emission.points).drive;
  const double amplitude = std::abs(ultrasound::pressureAt(layout, air, drive, head));
  EXPECT_LE(20.0 * std::log10(amplitude / std::sqrt(2.0) / 20e-6), 110.0);
  EXPECT_GT(20.0 * std::log10(amplitude / std::sqrt(2.0) / 20e-6), 109.5);
  EXPECT_LE(std::abs(ultrasound::pressureAt(layout, air, drive, loud.points[0].position)), 2000.0);
}

/// The returned drive is the one that was judged; it is not solved again.
TEST(SafetyGate, ReturnsTheDrivesThatItJudged) {
  std::vector<float> judged;
  int solved = 0;
  Instrument counting = instrument(quiet);
  const auto solve = counting.solve;
  counting.solve = [&](const Points& points, const ultrasound::Drive* before) {
    ++solved;
    return solve(points, before);
  };
  counting.loudness = [&](const ultrasound::Drive& drive, const Points& points) {
    judged.push_back(drive.phase.at(0));
    return loudness(points);
  };
  SafetyGate gate({}, counting);
  gate.start();
  const Verdict quiet_one = gate.check(emission(point(0, 0, 0.2, 0.1)), now());
  ASSERT_EQ(quiet_one.sound.parts.size(), 1u);
  EXPECT_EQ(solved, 1) << "once";
  EXPECT_EQ(quiet_one.sound.parts[0].drive.phase.at(0), judged.back());

  const Verdict lowered = gate.check(emission(point(0, 0, 0.2, 1.0)), now());
  ASSERT_EQ(lowered.sound.parts.size(), 1u);
  EXPECT_EQ(lowered.sound.parts[0].drive.phase.at(0), judged.back()) << "that of the weakest try";
  EXPECT_EQ(lowered.sound.parts[0].what.points.at(0).intensity,
            lowered.sound.emission.points.at(0).intensity);

  // Each part of a period, in the order of its instants.
  Emission path{{point(0, 0, 0.2, 0.1, 1), point(0.02, 0, 0.2, 0.1, 2)}, 100.0};
  path.modulation = ultrasound::Modulation::spatiotemporal;
  const Verdict run = gate.check(path, now());
  const auto played = instants(run.sound);
  ASSERT_EQ(played.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(played[k]->what.points.at(0).id, k + 1);
    EXPECT_EQ(played[k]->what.which.at(0), k);
    EXPECT_EQ(played[k]->drive.phase.at(0), judged[judged.size() - 2 + k]);
  }
  EXPECT_TRUE(gate.check({}, now()).sound.parts.empty());
  gate.stop();
  EXPECT_TRUE(gate.check(path, now()).sound.parts.empty());
}

/// If an array can play any share of a drive, a drive that is too loud is weakened, and not solved again.
TEST(SafetyGate, WeakensDrivesInProportion) {
  int solved = 0;
  Instrument array = instrument(quiet);
  array.scalable = true;
  const auto solve = array.solve;
  array.solve = [&](const Points& points, const ultrasound::Drive* before) {
    ++solved;
    ultrasound::PhaseSolution solution = solve(points, before);
    solution.target = {4000.0};
    return solution;
  };
  array.loudness = [](const ultrasound::Drive& drive, const Points&) {
    return Loudness{4000.0 * drive.amplitude.at(0), 100.0, ""};
  };
  SafetyGate gate({}, array);
  gate.start();
  const Verdict verdict = gate.check(emission(point(0, 0, 0.2, 0.8)), now());
  ASSERT_TRUE(verdict.passes()) << verdict.reason;
  EXPECT_EQ(solved, 1);
  const float amplitude = verdict.sound.parts.at(0).drive.amplitude.at(0);
  EXPECT_NEAR(amplitude, 0.4975f, 1e-6f);
  EXPECT_NEAR(verdict.sound.emission.points[0].intensity, 0.8 * 0.4975, 1e-9);
  EXPECT_NEAR(verdict.sound.parts[0].what.points[0].intensity, 0.8 * 0.4975, 1e-9);
  EXPECT_NEAR(verdict.sound.parts[0].target[0], 4000.0 * 0.4975, 1e-6);
  EXPECT_NEAR(verdict.head_spl.value(), 100.0 + 20.0 * std::log10(0.4975), 1e-9);
}

/// The drive before is that of the part before, and none after a silence.
TEST(SafetyGate, TellsTheSolverWhatPlayedBefore) {
  std::vector<float> before;
  Instrument array = instrument(quiet);
  const auto solve = array.solve;
  array.solve = [&](const Points& points, const ultrasound::Drive* drive) {
    before.push_back(drive == nullptr ? -1.0f : drive->phase.at(0));
    return solve(points, drive);
  };
  SafetyGate gate({}, array);
  gate.start();
  const Emission weak = emission(point(0, 0, 0.2, 0.1));
  gate.check(weak, now());
  gate.check(weak, now());
  gate.check({}, now());
  gate.check(weak, now());
  gate.fallSilent();
  gate.check(weak, now());
  EXPECT_EQ(before, (std::vector<float>{-1.0f, 0.0f, -1.0f, -1.0f}));
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

TEST(SafetyGate, RefusesBadSettingsByName) {
  const auto message = [](auto change) {
    SafetyGateConfig config;
    change(config);
    try {
      TestGate gate(config);
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
  EXPECT_NE(message([](auto& c) { c.intensity_slew = 0.0; }).find("intensity_slew"), std::string::npos);
  EXPECT_NE(message([](auto& c) { c.pressure_cap = nan; }).find("pressure_cap"), std::string::npos);
  EXPECT_NE(message([](auto& c) { c.head_spl_cap = nan; }).find("head_spl_cap"), std::string::npos);
}

/// Each rule against an emission that only it objects to.
struct Offence {
  Rule rule;
  std::function<Verdict(TestGate&)> commit;  // given a started gate
};

Verdict atOnce(TestGate& gate, const Emission& e, const Occasion& occasion = now()) {
  return gate.check(e, occasion, quiet);
}

const std::vector<Offence>& offences() {
  static const std::vector<Offence> all = {
      {Rule::emergency_stop,
       [](TestGate& gate) {
         gate.stop();
         return atOnce(gate, emission(point(0, 0, 0.2)));
       }},
      {Rule::stale,
       [](TestGate& gate) {
         Occasion occasion = now();
         occasion.age = 0.15;
         return atOnce(gate, emission(point(0, 0, 0.2)), occasion);
       }},
      {Rule::hand_lost,
       [](TestGate& gate) {
         Occasion occasion = now();
         occasion.hands_tracked = false;
         return atOnce(gate, emission(point(0, 0, 0.2)), occasion);
       }},
      {Rule::modulation,
       [](TestGate& gate) {
         Emission e = emission(point(0, 0, 0.2));
         e.modulation_frequency = 2000.0;
         return atOnce(gate, e);
       }},
      {Rule::non_finite, [](TestGate& gate) { return atOnce(gate, emission(point(nan, 0, 0.2))); }},
      {Rule::workspace, [](TestGate& gate) { return atOnce(gate, emission(point(0, 0, 0.5))); }},
      {Rule::intensity, [](TestGate& gate) { return atOnce(gate, emission(point(0, 0, 0.2, 1.2))); }},
      {Rule::slew, [](TestGate& gate) { return atOnce(gate, emission(point(0, 0, 0.2, 0.9)), now(0.01)); }},
      {Rule::pressure,
       [](TestGate& gate) {
         return gate.check(emission(point(0, 0, 0.2)), now(), [](const Points&) {
           return Loudness{5000.0, 0.0, ""};
         });
       }},
      {Rule::head_level,
       [](TestGate& gate) {
         return gate.check(emission(point(0, 0, 0.2)), now(), [](const Points&) {
           return Loudness{0.0, 130.0, ""};
         });
       }},
  };
  return all;
}

/// Whether it sounds as strongly as asked for.
bool soundsFully(const Verdict& verdict) {
  return verdict.passes() && !verdict.sound.emission.points.empty() && verdict.lowered.empty();
}

TEST(SafetyGate, EachRuleIsTheOnlyOneThatHoldsItsOffenceBack) {
  for (const Offence& offence : offences()) {
    SCOPED_TRACE(nameOf(offence.rule));
    const auto soundsWithout = [&](const std::set<Rule>& without) {
      SafetyGateConfig config;
      config.without = without;
      TestGate gate(config);
      gate.start();
      return soundsFully(offence.commit(gate));
    };
    EXPECT_FALSE(soundsWithout({})) << "the whole gate";
    EXPECT_TRUE(soundsWithout({offence.rule})) << "the gate without this rule";
    std::set<Rule> others;
    for (const Offence& other : offences())
      if (other.rule != offence.rule) others.insert(other.rule);
    EXPECT_FALSE(soundsWithout(others)) << "the gate with this rule only";
  }
}

/// An array of one transducer that could produce 1000 Pa at any sample, and produces the wanted share of the
/// amplitude that it may spend; with all of it, at most 3000 Pa and 120 dB.
class FieldGate : public ::testing::Test {
 protected:
  Instrument array = instrument(quiet);
  std::vector<double> spent;            // asked of it, one after the other
  std::vector<std::size_t> known;       // patterns before, that it was told of
  std::vector<double> efforts;          // asked of it
  std::vector<Eigen::Vector3d> places;  // of the first target
  std::size_t patterns = 1;
  double beside = 0.0;  // share of what it could have that bare skin gets

  FieldGate() {
    array.scalable = true;
    array.solve_field = [this](const Points& targets, double amplitude,
                               const std::vector<ultrasound::Drive>& before, double effort) {
      efforts.push_back(effort);
      places.push_back(targets.at(0).position);
      spent.push_back(amplitude);
      known.push_back(before.size());
      ultrasound::FieldSolution field;
      field.drives.assign(patterns, {{0.0f}, {static_cast<float>(amplitude)}});
      for (const auto& target : targets) {
        field.reach.push_back(1000.0);
        field.wanted.push_back(1000.0 * target.intensity);
        field.reached.push_back(1000.0 * amplitude * std::max(target.intensity, beside));
      }
      return field;
    };
    array.loudness = [](const ultrasound::Drive& drive, const Points&) {
      const double amplitude = drive.amplitude[0];
      return Loudness{3000.0 * amplitude, 120.0 + 20.0 * std::log10(std::max(amplitude, 1e-9)), ""};
    };
  }

  static SafetyGateConfig loudAllowed() {
    SafetyGateConfig config;
    config.pressure_cap = 1e6;
    config.head_spl_cap = 200.0;
    return config;
  }

  static Emission field(const Points& targets) { return {targets, 200.0, ultrasound::Modulation::field}; }
  static Emission fieldCircle(const Points& targets) {
    return {targets, 5.0, ultrasound::Modulation::field_circle};
  }
};

TEST_F(FieldGate, PassesWhatIsSolvedForIt) {
  SafetyGate gate(loudAllowed(), array);
  gate.start();
  const Verdict verdict = gate.check(field({point(0, 0, 0.2, 0.4), point(0.01, 0, 0.2, 0.0)}), now());
  EXPECT_EQ(verdict.reason, "");
  EXPECT_EQ(verdict.lowered, "");
  ASSERT_EQ(verdict.sound.parts.size(), 1u);
  EXPECT_EQ(verdict.sound.parts[0].what.instants.size(), ultrasound::period_steps);
  EXPECT_NEAR(verdict.sound.parts[0].what.power, 0.5, 1e-9);
  EXPECT_EQ(instants(verdict.sound).size(), ultrasound::period_steps);
  ASSERT_TRUE(verdict.field);
  EXPECT_EQ(verdict.field->reached[0], 400.0);
  gate.check(field({point(0, 0, 0.2, 0.4)}), now());
  gate.fallSilent();
  gate.check(field({point(0, 0, 0.2, 0.4)}), now());
  EXPECT_EQ(known, (std::vector<std::size_t>{0, 1, 0})) << "none before after silence";
}

TEST_F(FieldGate, PatternsShareThePeriod) {
  patterns = 4;
  SafetyGate gate(loudAllowed(), array);
  gate.start();
  const Verdict verdict = gate.check(field({point(0, 0, 0.2, 0.4)}), now());
  ASSERT_EQ(verdict.sound.parts.size(), 4u);
  for (const Sound::Part& part : verdict.sound.parts) {
    EXPECT_NEAR(part.what.time, 0.25, 1e-9);
    EXPECT_NEAR(part.what.power, 0.125, 1e-9) << "so that each counts as much in the mean";
  }
  const auto played = instants(verdict.sound);
  for (std::size_t i = 0; i < played.size(); ++i) EXPECT_EQ(played[i], &verdict.sound.parts[i % 4]);
}

TEST_F(FieldGate, SolvesEachPlaceOfACircleFromTheOneBefore) {
  patterns = 2;
  SafetyGate gate(loudAllowed(), array);
  gate.start();
  Emission circling = fieldCircle({point(0.01, 0, 0.2, 0.4), point(0.05, 0, 0.2, 0.0)});
  const Verdict verdict = gate.check(circling, now());
  EXPECT_EQ(verdict.reason, "");
  constexpr std::size_t steps = ultrasound::field_circle_steps;
  ASSERT_EQ(places.size(), steps);
  for (std::size_t k = 0; k < steps; ++k) {
    EXPECT_NEAR((places[k] - Eigen::Vector3d(0.01, 0, 0.2)).norm(), ultrasound::circle_radius, 1e-12);
    EXPECT_EQ(efforts[k], k == 0 ? 1.0 : 0.25);
    EXPECT_EQ(known[k], k == 0 ? 0u : 2u);
  }
  ASSERT_EQ(verdict.sound.parts.size(), 2 * steps);
  double time = 0.0;
  for (const Sound::Part& part : verdict.sound.parts) {
    EXPECT_EQ(part.what.power, part.what.time) << "always on";
    time += part.what.time;
  }
  EXPECT_NEAR(time, 1.0, 1e-9);
  EXPECT_EQ(verdict.sound.parts[3].what.points[0].position, places[1]);
  EXPECT_EQ(instants(verdict.sound).size(), 2 * steps);
  EXPECT_NEAR(verdict.field->reached[0], 400.0, 1e-9);
  gate.check(circling, now());
  EXPECT_EQ(known[steps], 2u) << "the next frame goes on from the first place";
}

TEST_F(FieldGate, LooksAtEveryPlaceOfACircle) {
  SafetyGateConfig config = loudAllowed();
  config.pressure_cap = 1500.0;
  array.loudness = [](const ultrasound::Drive& drive, const Points& points) {
    const bool loud = points.at(0).position.y() > 0.0029;
    return Loudness{(loud ? 3000.0 : 100.0) * static_cast<double>(drive.amplitude[0]), 0.0, ""};
  };
  SafetyGate gate(config, array);
  gate.start();
  Emission circling = fieldCircle({point(0, 0, 0.2, 0.4), point(0, 0.3, 0.2, 0.0)});
  const Verdict lowered = gate.check(circling, now());
  EXPECT_EQ(lowered.reason, "");
  EXPECT_TRUE(begins(lowered.lowered, "pressure"));
  for (const Sound::Part& part : lowered.sound.parts) EXPECT_LE(part.drive.amplitude[0], 0.5f);
  circling.points[0].position.x() = 0.198;
  EXPECT_TRUE(begins(gate.check(circling, now()).reason, "outside the workspace: x of focal point 7"));
  circling.points[0].position.x() = 0.0;
  circling.modulation_frequency = 0.0;
  EXPECT_TRUE(begins(gate.check(circling, now()).reason, "modulation: frequency is 0 Hz"));
}

TEST_F(FieldGate, BareSkinMayBeOutsideTheWorkspace) {
  SafetyGate gate(loudAllowed(), array);
  gate.start();
  const auto inside = point(0, 0, 0.2, 0.4);
  EXPECT_EQ(gate.check(field({inside, point(0, 0, 0.5, 0.0)}), now()).reason, "");
  EXPECT_TRUE(
      begins(gate.check(field({inside, point(0, 0, 0.5, 0.1)}), now()).reason, "outside the workspace"));
  EXPECT_TRUE(begins(gate.check(field({inside, point(nan, 0, 0.2, 0.0)}), now()).reason, "non-finite"));
  for (const double bad : {nan, inf, -1.0}) {
    auto weighed = inside;
    weighed.weight = bad;
    EXPECT_TRUE(begins(gate.check(field({weighed}), now()).reason, "non-finite: weight")) << bad;
  }
  EXPECT_TRUE(
      begins(gate.check(field({inside, point(0, 0, 0.2, 1.1)}), now()).reason, "intensity out of range"));
}

TEST_F(FieldGate, AsksAnewForLessWhereItIsTooLoud) {
  SafetyGateConfig config = loudAllowed();
  config.pressure_cap = 1500.0;
  SafetyGate gate(config, array);
  gate.start();
  const Verdict verdict = gate.check(field({point(0, 0, 0.2, 0.4)}), now());
  EXPECT_EQ(verdict.reason, "");
  EXPECT_TRUE(begins(verdict.lowered, "pressure"));
  ASSERT_EQ(spent.size(), 2u);
  EXPECT_NEAR(spent[1], 0.995 * 0.5, 1e-6);
  EXPECT_LE(verdict.sound.parts[0].drive.amplitude[0], 0.5f);

  config.pressure_cap = 1e6;
  config.head_spl_cap = 114.0;
  SafetyGate head(config, array);
  head.start();
  const Verdict lower = head.check(field({point(0, 0, 0.2, 0.4)}), now());
  EXPECT_TRUE(begins(lower.lowered, "head level"));
  EXPECT_LE(*lower.head_spl, 114.0);
}

TEST_F(FieldGate, IsWeakenedInProportionWhereAskingDoesNotHelp) {
  SafetyGateConfig config = loudAllowed();
  config.pressure_cap = 1500.0;
  array.loudness = [](const ultrasound::Drive&, const Points&) { return Loudness{3000.0, 0.0, ""}; };
  SafetyGate gate(config, array);
  gate.start();
  const Verdict verdict = gate.check(field({point(0, 0, 0.2, 0.4)}), now());
  EXPECT_EQ(verdict.reason, "");
  ASSERT_EQ(spent.size(), 2u);
  EXPECT_NEAR(verdict.field->reached[0], 0.5 * 1000.0 * spent[1] * 0.4, 10.0) << "and tells so";

  array.scalable = false;  // then it cannot be had
  SafetyGate boards(config, array);
  boards.start();
  EXPECT_TRUE(begins(boards.check(field({point(0, 0, 0.2, 0.4)}), now()).reason, "pressure"));
}

TEST_F(FieldGate, NoSampleGetsLouderFasterThanTheSlew) {
  SafetyGate gate(loudAllowed(), array);
  gate.start();
  constexpr double frame = 0.01;  // s: a rise of 0.2
  const auto share = [](const Verdict& verdict, std::size_t k) {
    return verdict.field->reached.at(k) / 1000.0;
  };
  const Points still{point(0, 0, 0.2, 0.5)};
  EXPECT_NEAR(share(gate.check(field(still), now(frame)), 0), 0.2, 2e-3);
  EXPECT_NEAR(share(gate.check(field(still), now(frame)), 0), 0.4, 4e-3);
  EXPECT_NEAR(share(gate.check(field(still), now(frame)), 0), 0.5, 5e-3);
  const Points moved{point(0.008, 0, 0.2, 0.5)};
  const Verdict next = gate.check(field(moved), now(frame));
  EXPECT_NEAR(share(next, 0), 0.5, 5e-3) << "what was within 10 mm may go on";
  EXPECT_EQ(next.lowered, "");
  const Verdict leap = gate.check(field({point(0.05, 0, 0.2, 0.5)}), now(frame));
  EXPECT_NEAR(share(leap, 0), 0.2, 2e-3);
  EXPECT_TRUE(begins(leap.lowered, "slew"));

  gate.fallSilent();
  beside = 0.6;  // bare skin counts as well
  EXPECT_NEAR(share(gate.check(field({point(0, 0, 0.2, 0.1), point(0.05, 0, 0.2, 0.0)}), now(frame)), 1), 0.2,
              2e-3);
  gate.fallSilent();
  const Verdict first = gate.check(field(still), now(0.0));
  EXPECT_EQ(first.reason, "");
  EXPECT_EQ(share(first, 0), 0.0) << "no time, no rise";
}

TEST_F(FieldGate, IsSilentWhereNothingIsKnown) {
  array.solve_field = [](const Points&, double, const std::vector<ultrasound::Drive>&,
                         double) -> ultrasound::FieldSolution { throw std::runtime_error("none"); };
  SafetyGate gate({}, array);
  gate.start();
  EXPECT_TRUE(begins(gate.check(field({point(0, 0, 0.2, 0.4)}), now()).reason, "pressure: not known"));
  array.solve_field = nullptr;
  SafetyGate without({}, array);
  without.start();
  EXPECT_TRUE(begins(without.check(field({point(0, 0, 0.2, 0.4)}), now()).reason, "pressure: not known"));
}

TEST(SafetyGate, RulesHaveNames) {
  for (const Offence& offence : offences()) EXPECT_EQ(ruleOf(nameOf(offence.rule)), offence.rule);
  EXPECT_EQ(nameOf(Rule::head_level), "head_level");
  try {
    ruleOf("head");
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("unknown rule 'head', expected one of emergency_stop"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace tactile_clay::device
