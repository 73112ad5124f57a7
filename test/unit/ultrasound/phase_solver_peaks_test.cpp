#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "oracle.h"
#include "phase_solver_fixture.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::ultrasound::phase_solver_peaks_test {
namespace {

TEST_F(PhaseSolver, OneFocusPeaksWhereItWasAsked) {
  const FocalPoint focus = point(-0.04, 0.03, 0.16);
  const PhaseSolution solution = solvePhases(layout, air, {focus});
  double peak = 0.0;
  Eigen::Vector3d at = focus.position;
  for (int i = -40; i <= 40; ++i) {
    for (int j = -40; j <= 40; ++j) {
      const Eigen::Vector3d x = focus.position + Eigen::Vector3d(0.001 * i, 0.001 * j, 0.0);
      const double p = heardAmplitude(layout, air, solution.drive, x);
      if (p > peak) {
        peak = p;
        at = x;
      }
    }
  }
  EXPECT_LT((at - focus.position).norm(), air.wavelength() / 4.0);
}

/// Foci 12 to 16 mm apart overlap, because each is some 14 mm wide. If slopes are not limited, the peaks of
/// their sum are beside them. Peaks are searched uphill in the plane of the focus, in the field of another
/// formula.
TEST_F(PhaseSolver, FociArePeaks) {
  // On a palm of 60 x 60 mm, 12 mm apart and more, so that neighbours overlap.
  std::mt19937 dice(7);
  std::uniform_real_distribution<double> place(-0.03, 0.03);
  std::uniform_real_distribution<double> intensity(0.6, 1.0);
  std::vector<std::vector<FocalPoint>> sets(10);
  for (auto& foci : sets) {
    while (foci.size() < 8) {
      FocalPoint next;
      next.position = {place(dice), place(dice), 0.18};
      next.intensity = intensity(dice);
      bool free = true;
      for (const FocalPoint& f : foci) free = free && (f.position - next.position).norm() > 0.012;
      if (free) foci.push_back(next);
    }
  }
  const auto missed = [&](bool peaks, int levels) {
    PhaseSolverOptions options;
    options.peaks = peaks;
    options.phase_levels = levels;
    int count = 0;
    for (const auto& foci : sets) {
      const PhaseSolution solution = solvePhases(layout, air, foci, options);
      EXPECT_LE(rmsError(solution, foci), 0.02);
      for (const FocalPoint& focus : foci) count += distance(solution.drive, focus.position) < 0.002 ? 0 : 1;
    }
    return count;
  };
  EXPECT_LE(missed(true, 0), 2) << "of 80";
  EXPECT_LE(missed(true, 32), 2) << "of 80";
  EXPECT_GE(missed(false, 0), 8) << "else this test tests nothing";
}

/// Weak foci lie between the lobes of strong ones, where the amplitude often bends upwards. The foci here are
/// weaker than any that the renderer commands, beside three strong ones. On a ridge between lobes a few have
/// no peak.
TEST_F(PhaseSolver, MostWeakFociBesideStrongOnesArePeaks) {
  std::mt19937 dice(8);
  std::uniform_real_distribution<double> place(-0.04, 0.04);
  const auto missed = [&](bool peaks) {
    dice.seed(8);
    int count = 0;
    for (int trial = 0; trial < 20; ++trial) {
      std::vector<FocalPoint> foci;
      while (foci.size() < 4) {
        const FocalPoint next = point(place(dice), place(dice), 0.18, foci.empty() ? 0.15 : 1.0);
        bool free = true;
        for (const FocalPoint& f : foci) free = free && (f.position - next.position).norm() > 0.016;
        if (free) foci.push_back(next);
      }
      PhaseSolverOptions options;
      options.peaks = peaks;
      const PhaseSolution solution = solvePhases(layout, air, foci, options);
      EXPECT_LE(rmsError(solution, foci), 0.02);
      const Eigen::Vector3d weak = foci[0].position;
      count += distance(solution.drive, weak) < 0.002 ? 0 : 1;
    }
    return count;
  };
  EXPECT_LE(missed(true), 4) << "of 20";
  EXPECT_GE(missed(false), 12) << "else this test tests nothing";
}

}  // namespace
}  // namespace tactile_clay::ultrasound::phase_solver_peaks_test
