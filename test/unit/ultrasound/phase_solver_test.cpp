#include "ultrasound/phase_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "oracle.h"

namespace tactile_clay::ultrasound {
namespace {

class PhaseSolver : public ::testing::Test {
 protected:
  ArrayLayout layout = arrayLayout("usx");
  Acoustics air;
  std::mt19937 random{21};

  static FocalPoint point(double x, double y, double z, double intensity = 1.0) {
    FocalPoint p;
    p.position = {x, y, z};
    p.intensity = intensity;
    return p;
  }

  /// Foci at least 12 mm apart in the room a hand takes.
  std::vector<FocalPoint> randomFoci(std::size_t count) {
    std::uniform_real_distribution<double> place(-0.05, 0.05);
    std::vector<FocalPoint> foci;
    while (foci.size() < count) {
      const FocalPoint next = point(place(random), place(random), 0.18 + 0.4 * place(random));
      bool free = true;
      for (const auto& f : foci) free = free && (f.position - next.position).norm() > 0.012;
      if (free) foci.push_back(next);
    }
    return foci;
  }

  /// Relative RMS of the amplitudes that an independent field has at the foci, about their common scale.
  double rmsError(const PhaseSolution& solution, const std::vector<FocalPoint>& foci) {
    std::vector<double> share;
    double mean = 0.0;
    for (std::size_t k = 0; k < foci.size(); ++k) {
      share.push_back(heardAmplitude(layout, air, solution.drive, foci[k].position) / solution.target[k]);
      mean += share.back() / static_cast<double>(foci.size());
    }
    double square = 0.0;
    for (const double s : share) square += std::pow(s / mean - 1.0, 2);
    return std::sqrt(square / static_cast<double>(foci.size()));
  }
};

TEST_F(PhaseSolver, OneFocusReachesAllThatTheArrayCanGive) {
  const FocalPoint focus = point(0.03, -0.02, 0.2);
  const PhaseSolution solution = solvePhases(layout, air, {focus});
  const double most = focusPressure(layout, air, focus.position);
  EXPECT_NEAR(heardAmplitude(layout, air, solution.drive, focus.position), most, 1e-4 * most);
  EXPECT_NEAR(solution.reached[0], most, 1e-4 * most);
  air.attenuation = 0.0;  // as the figure was computed
  const PhaseSolution centre = solvePhases(layout, air, {point(0, 0, 0.2)});
  EXPECT_NEAR(centre.reached[0], 3623.0, 0.02 * 3623.0);
}

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
      EXPECT_NEAR(solution.target[k], share, 1e-5 * share);  // single precision
      // These ask for 70 % of the power of six full foci, so that the array can serve them all.
      EXPECT_NEAR(heardAmplitude(layout, air, solution.drive, foci[k].position), share, 0.05 * share);
    }
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
  // Foci that move by 0.2 mm: from the last phases the drive changes less than anew, and is as accurate.
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
  const Drive other{std::vector<float>(249), std::vector<float>(249)};
  EXPECT_THROW(solvePhases(layout, air, {point(0, 0, 0.2)}, {}, &other), std::invalid_argument);
}

}  // namespace
}  // namespace tactile_clay::ultrasound
