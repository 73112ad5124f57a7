#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "device/safety_gate.h"
#include "gates.h"

namespace tactile_clay::device::safety_gate_field_test {
namespace {

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
  double cosine = 1.0;  // of the incidence on all skin

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
        field.on_skin.push_back(cosine * field.reached.back());
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

// Skin at an angle feels less, but the rules stay those of the sound without skin.
TEST_F(FieldGate, TheAngleOfTheSkinWeakensNoRule) {
  cosine = 0.3;
  SafetyGate gate(loudAllowed(), array);
  gate.start();
  const Verdict first = gate.check(field({point(0, 0, 0.2, 0.5)}), now(0.01));
  EXPECT_NEAR(first.field->reached[0], 200.0, 2.0) << "the slew";
  EXPECT_NEAR(first.field->on_skin[0], 60.0, 0.6) << "is lowered with it";
  EXPECT_NEAR(gate.check(field({point(0, 0, 0.2, 0.5)}), now(0.01)).field->reached[0], 400.0, 4.0);
  const Verdict circle = gate.check(fieldCircle({point(0, 0, 0.2, 0.4)}), now(1.0));
  EXPECT_NEAR(circle.field->on_skin.at(0), 0.3 * circle.field->reached.at(0), 1e-9);
  EXPECT_NEAR(circle.field->scale, 0.09, 1e-9) << "what presses is told";

  Points points{point(0, 0, 0.2, 0.4)};
  points[0].normal.y() = std::nan("");
  EXPECT_TRUE(begins(gate.check(field(points), now()).reason, "non-finite: normal of focal point"))
      << "unknown";
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

}  // namespace
}  // namespace tactile_clay::device::safety_gate_field_test
