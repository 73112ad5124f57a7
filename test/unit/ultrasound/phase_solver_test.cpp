#include "ultrasound/phase_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "oracle.h"
#include "phase_solver_fixture.h"

namespace tactile_clay::ultrasound::phase_solver_test {
namespace {

TEST_F(PhaseSolver, OneFocusReachesAllThatTheArrayCanGive) {
  const FocalPoint focus = point(0.03, -0.02, 0.2);
  const PhaseSolution solution = solvePhases(layout, air, {focus});
  const double maximum = focusPressure(layout, air, focus.position);
  EXPECT_NEAR(heardAmplitude(layout, air, solution.drive, focus.position), maximum, 1e-4 * maximum);
  EXPECT_NEAR(solution.reached[0], maximum, 1e-4 * maximum);
  air.attenuation = 0.0;  // as the figure was computed
  const PhaseSolution centre = solvePhases(layout, air, {point(0, 0, 0.2)});
  EXPECT_NEAR(centre.reached[0], 3623.0, 0.02 * 3623.0);
}

TEST_F(PhaseSolver, IntensityOfOneFocusScalesTheAmplitude) {
  for (const double intensity : {0.01, 0.25, 0.5, 1.0}) {
    const FocalPoint focus = point(0.01, 0.02, 0.18, intensity);
    const PhaseSolution solution = solvePhases(layout, air, {focus});
    const double expected = intensity * focusPressure(layout, air, focus.position);
    EXPECT_NEAR(heardAmplitude(layout, air, solution.drive, focus.position), expected, 1e-3 * expected);
    for (const float a : solution.drive.amplitude) EXPECT_NEAR(a, intensity, 1e-4);
  }
}

TEST_F(PhaseSolver, EightEqualFociAreEqualWithinTwoPercent) {
  double mean = 0.0;
  double pressure = 0.0;
  for (int trial = 0; trial < 30; ++trial) {
    const auto foci = randomFoci(8);
    const PhaseSolution solution = solvePhases(layout, air, foci);
    const double error = rmsError(solution, foci);
    for (std::size_t k = 0; k < 8; ++k) {
      const double heard = heardAmplitude(layout, air, solution.drive, foci[k].position);
      EXPECT_NEAR(solution.reached[k], heard, 1e-3 * heard);
    }
    EXPECT_LE(error, 0.02) << trial;
    mean += error / 30.0;
    for (const auto& f : foci) pressure += heardAmplitude(layout, air, solution.drive, f.position) / 240.0;
  }
  RecordProperty("mean_error_ppm", static_cast<int>(1e6 * mean));
  RecordProperty("mean_pressure_pa", static_cast<int>(pressure));
  EXPECT_LT(mean, 0.0098);  // a prototype's damped weighted GS after 20 passes
  EXPECT_GT(pressure,
            1200.0);  // phase-only weighted GS was measured at 1306 Pa, power-hungry solvers at 672 Pa
}

TEST_F(PhaseSolver, SixteenFociAndOtherArrays) {
  for (const char* name : {"usx", "uhev1", "sonic_surface", "autd3"}) {
    layout = arrayLayout(name);
    for (const std::size_t count : {2u, 4u, 16u}) {
      const auto foci = randomFoci(count);
      PhaseSolverOptions options;
      options.iterations = 100;
      EXPECT_LE(rmsError(solvePhases(layout, air, foci, options), foci), 0.02) << name << ' ' << count;
    }
  }
}

TEST_F(PhaseSolver, UnequalFociKeepTheirRatios) {
  for (int trial = 0; trial < 10; ++trial) {
    auto foci = randomFoci(6);
    const double intensities[] = {1.0, 0.9, 0.7, 0.5, 0.4, 0.3};
    for (std::size_t k = 0; k < 6; ++k) foci[k].intensity = intensities[k];
    const PhaseSolution solution = solvePhases(layout, air, foci);
    EXPECT_LE(rmsError(solution, foci), 0.02);
    for (std::size_t k = 0; k < 6; ++k) {
      const double share = intensities[k] * focusPressure(layout, air, foci[k].position) / std::sqrt(6.0);
      // The solver sums the amplitudes of 256 transducers in single precision, each accurate to some 1e-6. In
      // double precision this sum would take longer than the rest of the solver.
      EXPECT_NEAR(solution.target[k], share, 1e-5 * share);
      // These ask for 70 % of the power of six full foci, so that the array can serve them all.
      EXPECT_NEAR(heardAmplitude(layout, air, solution.drive, foci[k].position), share, 0.05 * share);
    }
  }
}

/// A weak focus above or below a strong one gets too much pressure in every drive of much power, and no small
/// change of the phases helps: errors from such starts are 30 to 77 %.
TEST_F(PhaseSolver, AWeakFocusOnTheAxisOfAStrongOneIsNoStronger) {
  const std::vector<std::vector<FocalPoint>> sets = {
      {point(0.0, 0.0, 0.2, 0.9), point(0.001, 0.0, 0.186, 0.12), point(0.03, 0.02, 0.19, 0.8),
       point(-0.03, 0.01, 0.18, 0.7), point(0.01, -0.035, 0.2, 1.0), point(-0.02, -0.03, 0.19, 0.6),
       point(0.0, 0.04, 0.18, 0.8), point(-0.04, 0.04, 0.2, 0.9)},
      {point(0.022, 0.005, 0.182, 0.15), point(0.024, -0.018, 0.163, 0.96), point(0.016, -0.004, 0.189, 0.53),
       point(-0.038, 0.01, 0.19, 0.77), point(0.005, 0.043, 0.198, 0.89), point(-0.013, -0.023, 0.181, 0.69),
       point(-0.034, 0.006, 0.178, 0.1), point(-0.008, -0.01, 0.199, 0.15)},
      {point(0.043, 0.041, 0.25, 0.27), point(0.029, -0.034, 0.18, 0.7), point(-0.007, -0.004, 0.176, 0.13),
       point(-0.014, 0.033, 0.308, 0.17), point(0.005, -0.015, 0.2, 0.99), point(0.031, 0.001, 0.227, 0.93),
       point(-0.012, 0.028, 0.282, 0.76), point(-0.004, 0.019, 0.309, 0.37)}};
  PhaseSolverOptions options;
  options.phase_levels = 32;
  air.attenuation = 0.0;  // as the figures of such arrays
  for (const auto& foci : sets) {
    const PhaseSolution solution = solvePhases(layout, air, foci, options);
    EXPECT_LE(rmsError(solution, foci), 0.01);
  }
}

TEST_F(PhaseSolver, AmplitudesStayInRange) {
  for (int trial = 0; trial < 10; ++trial) {
    for (const double intensity : {0.1, 0.6, 1.0}) {
      auto foci = randomFoci(1 + static_cast<std::size_t>(trial));
      for (auto& f : foci) f.intensity = intensity;
      const PhaseSolution solution = solvePhases(layout, air, foci);
      for (std::size_t n = 0; n < layout.size(); ++n) {
        EXPECT_GE(solution.drive.amplitude[n], 0.0f);
        EXPECT_LE(solution.drive.amplitude[n], 1.0f);
        EXPECT_GE(solution.drive.phase[n], 0.0f);
        EXPECT_LE(solution.drive.phase[n], 6.2831855f);
      }
    }
  }
}

TEST_F(PhaseSolver, NoFocusIsSilence) {
  for (const auto& points : {std::vector<FocalPoint>{}, std::vector<FocalPoint>{point(0, 0, 0.2, 0.0)},
                             std::vector<FocalPoint>{point(0, 0, -0.2)}}) {
    const PhaseSolution solution = solvePhases(layout, air, points);
    ASSERT_EQ(solution.drive.amplitude.size(), layout.size());
    for (std::size_t n = 0; n < layout.size(); ++n) {
      EXPECT_EQ(solution.drive.amplitude[n], 0.0f);
      EXPECT_EQ(solution.drive.phase[n], 0.0f);
    }
  }
}

TEST_F(PhaseSolver, AFocusWithoutIntensityTakesNothing) {
  const auto with = solvePhases(layout, air, {point(0, 0, 0.2), point(0.03, 0, 0.2, 0.0)});
  const auto without = solvePhases(layout, air, {point(0, 0, 0.2)});
  EXPECT_EQ(with.drive.phase, without.drive.phase);
  EXPECT_EQ(with.drive.amplitude, without.drive.amplitude);
  EXPECT_EQ(with.target[1], 0.0);
}

TEST_F(PhaseSolver, CoincidentFociDoNotBreakIt) {
  const auto solution = solvePhases(layout, air, {point(0, 0, 0.2), point(0, 0, 0.2), point(0.03, 0, 0.2)});
  for (const float a : solution.drive.amplitude) EXPECT_TRUE(std::isfinite(a));
  for (const double p : solution.reached) EXPECT_GT(p, 1000.0);
}

TEST_F(PhaseSolver, WarmStartKeepsThePhasesNear) {
  // Foci that move by 0.2 mm: if the solver starts from the last phases, the drive changes less than with a
  // new start, and is as accurate.
  auto foci = randomFoci(6);
  PhaseSolution last = solvePhases(layout, air, foci);
  for (auto& f : foci) f.position.x() += 2e-4;
  const PhaseSolution warm = solvePhases(layout, air, foci, {}, &last.drive);
  EXPECT_LE(rmsError(warm, foci), 0.02);
  double change = 0.0;
  for (std::size_t n = 0; n < layout.size(); ++n) {
    change = std::max<double>(
        change, std::abs(std::remainder(warm.drive.phase[n] - last.drive.phase[n], 2.0 * M_PI)));
  }
  EXPECT_LT(change, 0.8);  // 0.2 mm of way is 0.15 rad; more where a transducer is weakly bound
}

TEST_F(PhaseSolver, MethodsAreAsAccurateAsTheyClaim) {
  // Mean error of eight equal foci, 100 passes: figures measured on other libraries bound GS-PAT (2.65 % on
  // its own foci, twice that allowed here) and damped weighted Gerchberg-Saxton; naive has no bound below 100
  // %.
  std::vector<double> error(4, 0.0);
  PhaseSolverOptions options;
  options.iterations = 100;
  for (int trial = 0; trial < 30; ++trial) {
    const auto foci = randomFoci(8);
    for (int method = 0; method < 4; ++method) {
      options.method = static_cast<PhaseMethod>(method);
      error[static_cast<std::size_t>(method)] +=
          rmsError(solvePhases(layout, air, foci, options), foci) / 30.0;
    }
  }
  const auto of = [&error](PhaseMethod method) { return error[static_cast<std::size_t>(method)]; };
  EXPECT_LT(of(PhaseMethod::newton), 0.0005);
  EXPECT_LT(of(PhaseMethod::weighted_gerchberg_saxton), 0.005);
  EXPECT_LT(of(PhaseMethod::gs_pat), 0.08);
  EXPECT_LT(of(PhaseMethod::newton), of(PhaseMethod::weighted_gerchberg_saxton));
  EXPECT_LT(of(PhaseMethod::weighted_gerchberg_saxton), of(PhaseMethod::gs_pat));
  EXPECT_LT(of(PhaseMethod::gs_pat), of(PhaseMethod::naive));
}

TEST_F(PhaseSolver, OwnAmplitudesSpareTransducersThatAreHardlyNeeded) {
  PhaseSolverOptions options;
  options.phase_only = false;
  double waste_own = 0.0;
  double waste_common = 0.0;
  for (int trial = 0; trial < 20; ++trial) {
    const auto foci = randomFoci(8);
    // Power at the foci over the power sent: the squares of amplitudes.
    const auto efficiency = [&](const PhaseSolution& s) {
      double power = 0.0;
      double heard = 0.0;
      for (const float a : s.drive.amplitude) power += a * a;
      for (const double p : s.reached) heard += p * p;
      return heard / power;
    };
    const PhaseSolution own = solvePhases(layout, air, foci, options);
    EXPECT_LE(rmsError(own, foci), 0.002);
    EXPECT_LT(*std::min_element(own.drive.amplitude.begin(), own.drive.amplitude.end()), 0.5f);
    for (const float a : own.drive.amplitude) EXPECT_LE(a, 1.0f);
    waste_own += 1.0 / efficiency(own);
    waste_common += 1.0 / efficiency(solvePhases(layout, air, foci));
  }
  EXPECT_LT(waste_own, 0.95 * waste_common);
}

TEST(PhaseMethod, IsNamed) {
  EXPECT_EQ(phaseMethod("naive"), PhaseMethod::naive);
  EXPECT_EQ(phaseMethod("weighted_gerchberg_saxton"), PhaseMethod::weighted_gerchberg_saxton);
  EXPECT_EQ(phaseMethod("gs_pat"), PhaseMethod::gs_pat);
  EXPECT_EQ(phaseMethod("newton"), PhaseMethod::newton);
  try {
    phaseMethod("magic");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(
        error.what(),
        "unknown phase method 'magic', expected one of: gs_pat, naive, newton, weighted_gerchberg_saxton");
  }
}

TEST_F(PhaseSolver, IsDeterministic) {
  const auto foci = randomFoci(8);
  const PhaseSolution a = solvePhases(layout, air, foci);
  const PhaseSolution b = solvePhases(layout, air, foci);
  EXPECT_EQ(a.drive.phase, b.drive.phase);
  EXPECT_EQ(a.drive.amplitude, b.drive.amplitude);
}

TEST_F(PhaseSolver, RefusesBadInput) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(solvePhases(layout, air, {point(nan, 0, 0.2)}), std::invalid_argument);
  EXPECT_THROW(solvePhases(layout, air, {point(0, 0, 0.2, nan)}), std::invalid_argument);
  EXPECT_THROW(solvePhases(layout, air, {point(0, 0, 0.2, 1.1)}), std::invalid_argument);
  PhaseSolverOptions options;
  options.iterations = 0;
  EXPECT_THROW(solvePhases(layout, air, {}, options), std::invalid_argument);
  for (const auto& wrong : {std::make_pair(&PhaseSolverOptions::phase_levels, 1),
                            std::make_pair(&PhaseSolverOptions::amplitude_levels, -1)}) {
    PhaseSolverOptions bad;
    bad.*wrong.first = wrong.second;
    EXPECT_THROW(solvePhases(layout, air, {}, bad), std::invalid_argument);
  }
  PhaseSolverOptions backwards;
  backwards.max_phase_change = -0.1;
  EXPECT_THROW(solvePhases(layout, air, {}, backwards), std::invalid_argument);
  Drive broken{std::vector<float>(256, std::numeric_limits<float>::quiet_NaN()), std::vector<float>(256)};
  EXPECT_THROW(solvePhases(layout, air, {point(0, 0, 0.2)}, {}, &broken), std::invalid_argument);
  const Drive other{std::vector<float>(249), std::vector<float>(249)};
  EXPECT_THROW(solvePhases(layout, air, {point(0, 0, 0.2)}, {}, &other), std::invalid_argument);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::phase_solver_test
