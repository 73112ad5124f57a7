#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "device/safety_gate.h"
#include "gates.h"
#include "ultrasound/acoustic_field.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::device::safety_gate_loudness_test {
namespace {

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

/// If the loudness of one place is unknown or not a number, the array is silent, whichever place it is.
/// @param path of the points 0, 1 and 2
void expectSilenceForOneUnknownPlace(TestGate& gate, const Emission& path) {
  for (const std::size_t bad : {0u, 1u, 2u}) {
    for (const std::optional<double> what : {std::optional<double>(), std::optional<double>(nan)}) {
      const auto part = [&](const Points& points) {
        return points[0].id == bad ? Loudness{what, 0.0, ""} : Loudness{100.0, 0.0, ""};
      };
      EXPECT_TRUE(begins(gate.check(path, now(), part).reason, "pressure")) << bad;
    }
  }
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
  expectSilenceForOneUnknownPlace(gate, path);
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

}  // namespace
}  // namespace tactile_clay::device::safety_gate_loudness_test
