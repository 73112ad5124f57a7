#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "oracle.h"
#include "phase_solver_fixture.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::ultrasound::phase_solver_levels_test {
namespace {

TEST_F(PhaseSolver, EightFociOn32LevelsAreWithinOnePercent) {
  // Equal and unequal targets, phases rounded to 32 levels, on the array of the table of achievable pressures
  // (air without attenuation): 1.0 % of RMS error, at least 1250 Pa on each of eight equal foci.
  air.attenuation = 0.0;
  PhaseSolverOptions options;
  options.phase_levels = 32;
  std::uniform_real_distribution<double> intensity(0.3, 1.0);
  for (const bool equal : {true, false}) {
    double mean = 0.0;
    double pressure = 0.0;
    for (int trial = 0; trial < 50; ++trial) {
      auto foci = randomFoci(8);
      if (!equal) {
        for (auto& f : foci) f.intensity = intensity(random);
      }
      const PhaseSolution solution = solvePhases(layout, air, foci, options);
      const double error = rmsError(solution, foci);
      EXPECT_LE(error, 0.01) << trial;
      mean += error / 50.0;
      for (std::size_t k = 0; k < 8; ++k) {
        const double heard = heardAmplitude(layout, air, solution.drive, foci[k].position);
        EXPECT_NEAR(solution.reached[k], heard, 1e-3 * heard);
        pressure += heard / 400.0;
      }
    }
    EXPECT_LE(mean, 0.005);
    if (equal) {
      EXPECT_GE(pressure, 1250.0);
    }
  }
}

TEST_F(PhaseSolver, PhasesAndAmplitudesLieOnTheLevels) {
  for (const int levels : {2, 3, 16, 32, 256}) {
    for (const bool phase_only : {true, false}) {
      PhaseSolverOptions options;
      options.phase_levels = levels;
      options.amplitude_levels = levels;
      options.phase_only = phase_only;
      auto foci = randomFoci(5);
      foci[2].intensity = 0.4;
      const PhaseSolution solution = solvePhases(layout, air, foci, options);
      for (std::size_t n = 0; n < layout.size(); ++n) {
        const double step = solution.drive.phase[n] * levels / (2.0 * M_PI);
        EXPECT_NEAR(step, std::round(step), 1e-4);
        EXPECT_LT(solution.drive.phase[n], 2.0 * M_PI - 1e-3);
        const double share = solution.drive.amplitude[n] * static_cast<double>(levels);
        EXPECT_NEAR(share, std::round(share), 1e-3);
      }
      for (std::size_t k = 0; k < foci.size(); ++k) {
        const double heard = heardAmplitude(layout, air, solution.drive, foci[k].position);
        EXPECT_NEAR(solution.reached[k], heard, 2e-3 * heard) << levels;
      }
    }
  }
}

TEST_F(PhaseSolver, RoundingLeavesLessErrorThanTheClosestLevels) {
  double diffused = 0.0;
  double closest = 0.0;
  for (int trial = 0; trial < 20; ++trial) {
    const auto foci = randomFoci(8);
    PhaseSolution exact = solvePhases(layout, air, foci);
    PhaseSolverOptions options;
    options.phase_levels = 32;
    diffused += rmsError(solvePhases(layout, air, foci, options), foci);
    for (float& phase : exact.drive.phase) {
      phase = static_cast<float>(std::round(phase * 16.0 / M_PI) * M_PI / 16.0);
    }
    closest += rmsError(exact, foci);
  }
  EXPECT_LT(diffused, 0.3 * closest);
}

TEST_F(PhaseSolver, PhasesChangeNoMoreThanTheLimit) {
  for (const int levels : {0, 32}) {
    PhaseSolverOptions options;
    options.phase_levels = levels;
    options.max_phase_change = 0.5;
    auto foci = randomFoci(6);
    Drive last = solvePhases(layout, air, foci, options).drive;
    for (int step = 0; step < 40; ++step) {
      for (auto& f : foci) f.position += Eigen::Vector3d(3e-4, -2e-4, 1e-4);  // 0.3 rad of way
      const PhaseSolution now = solvePhases(layout, air, foci, options, &last);
      for (std::size_t n = 0; n < layout.size(); ++n) {
        ASSERT_LE(std::abs(std::remainder(now.drive.phase[n] - last.phase[n], 2.0 * M_PI)), 0.5 + 1e-3);
      }
      EXPECT_LE(rmsError(now, foci), 0.02) << levels << ", step " << step;
      last = now.drive;
    }
    // With the limit a jump may be reached only after some frames; without it, at once.
    foci = randomFoci(6);
    bool followed = false;
    for (int step = 0; step < 20 && !followed; ++step) {
      const PhaseSolution now = solvePhases(layout, air, foci, options, &last);
      double change = 0.0;
      for (std::size_t n = 0; n < layout.size(); ++n) {
        const double phase = std::remainder(now.drive.phase[n] - last.phase[n], 2.0 * M_PI);
        change = std::max(change, std::abs(phase));
      }
      EXPECT_LE(change, 0.5 + 1e-3);
      followed = rmsError(now, foci) < 0.01 && now.reached[0] > 0.9 * now.target[0];
      EXPECT_FALSE(followed && step == 0);
      last = now.drive;
    }
    EXPECT_TRUE(followed);
  }
}

TEST_F(PhaseSolver, FromSilenceNoPhaseIsLimited) {
  PhaseSolverOptions options;
  options.max_phase_change = 0.01;
  const auto foci = randomFoci(4);
  const Drive silent{std::vector<float>(256, 0.0f), std::vector<float>(256, 0.0f)};
  EXPECT_LE(rmsError(solvePhases(layout, air, foci, options, &silent), foci), 0.001);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::phase_solver_levels_test
