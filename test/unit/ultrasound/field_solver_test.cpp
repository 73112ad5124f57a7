#include "ultrasound/field_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "field_solver_fixture.h"
#include "ultrasound/field_objective.h"

namespace tactile_clay::ultrasound::field_solver_test {
namespace {

TEST_F(FieldSolver, GradientIsThatOfTheObjectiveInDoublePrecision) {
  const auto even = targets(fingers(3, 2, 0.004, true));
  for (const auto& [patterns, blur] : {std::pair{1, 0.0}, std::pair{2, 0.0}, std::pair{1, 0.004}}) {
    auto points = even;
    for (std::size_t m = 0; blur > 0.0 && m < points.size(); ++m)
      points[m].weight = 0.25 * static_cast<double>(m % 5);
    FieldSolverOptions options;
    options.patterns = patterns;
    options.blur = blur;
    FieldObjective solver(layout, air, points, options);
    const std::vector<Drive> drives = randomDrives(static_cast<std::size_t>(patterns), 5);
    Turns turns(solver.size(), Lanes{}), gradient(solver.size());
    for (std::size_t k = 0; k < drives.size(); ++k)
      for (std::size_t n = 0; n < layout.size(); ++n)
        turns[k * solver.width() + n / wide_lane_count][n % wide_lane_count] =
            drives[k].phase[n] * static_cast<float>(0.5 / M_PI);
    const double value = solver(turns, &gradient);
    const double expected = objective(points, drives, options);
    EXPECT_NEAR(value, expected, 1e-4 * expected);

    double steepest = 0.0;
    for (const Lanes& lane : gradient)
      for (std::size_t i = 0; i < wide_lane_count; ++i)
        steepest = std::max(steepest, std::abs(double{lane[i]}));
    ASSERT_GT(steepest, 0.0);
    for (const std::size_t n : {0u, 17u, 130u, 255u}) {
      const std::size_t k = n % drives.size();
      constexpr double step = 1e-3;  // turns
      double at[2];
      for (const int side : {0, 1}) {
        std::vector<Drive> moved = drives;
        moved[k].phase[n] += static_cast<float>(2.0 * M_PI * (side == 0 ? -step : step));
        at[side] = objective(points, moved, options);
      }
      EXPECT_NEAR(gradient[k * solver.width() + n / wide_lane_count][n % wide_lane_count],
                  (at[1] - at[0]) / (2.0 * step), 5e-3 * steepest)
          << n;
    }
  }
}

TEST_F(FieldSolver, TellsTheTrueFieldAtTheTargets) {
  const auto points = targets(fingers(4, 3, 0.004, true));
  FieldSolverOptions options;
  options.patterns = 2;
  const FieldSolution solution = solveField(layout, air, points, options);
  FieldSolution judged = solution;
  judgeField(layout, air, points, judged);
  EXPECT_NEAR(solution.error, judged.error, 1e-3);
  EXPECT_NEAR(solution.scale, judged.scale, 1e-3 * judged.scale);
  for (std::size_t m = 0; m < points.size(); ++m) {
    EXPECT_NEAR(solution.reach[m], focusPressure(layout, air, points[m].position), 1e-4 * solution.reach[m]);
    EXPECT_DOUBLE_EQ(solution.wanted[m], points[m].intensity * solution.reach[m]);
    double square = 0.0, on_skin = 0.0;
    for (const Drive& drive : solution.drives) {
      square += 0.5 * std::norm(pressureAt(layout, air, drive, points[m].position));
      on_skin += 0.5 * std::norm(amplitudeOnSkin(layout, air, drive, points[m].position, points[m].normal));
    }
    EXPECT_NEAR(solution.reached[m], std::sqrt(square), 1e-4 * solution.reach[m]);
    EXPECT_NEAR(solution.on_skin[m], std::sqrt(on_skin), 1e-4 * solution.reach[m]);
    EXPECT_NEAR(judged.reached[m], solution.reached[m], 1e-4 * solution.reach[m]);
    EXPECT_NEAR(judged.on_skin[m], solution.on_skin[m], 1e-4 * solution.reach[m]);
  }
}

// The limit that the paper names, "prevents matching large pressure areas", is a limit of focal points.
TEST_F(FieldSolver, HalvesTheErrorOfFocalPointsOnLargeContacts) {
  expectBetterThanFocalPoints(0.5, [](unsigned seed, double step) { return palm(seed, step); });
}

// Contacts of the size of a focus, for which focal points are good.
TEST_F(FieldSolver, IsBetterThanFocalPointsAlsoOnFingerTips) {
  expectBetterThanFocalPoints(
      0.7, [](unsigned seed, double step) { return fingers(seed, 1 + static_cast<int>(seed % 4), step); });
}

TEST_F(FieldSolver, TradesErrorForPressure) {
  auto points = targets(fingers(6, 3, 0.004));
  for (FocalPoint& point : points) point.intensity *= 2.0;  // more than there is
  double error = 0.0, scale = 0.0;
  for (const double strength : {0.01, 0.1, 0.5}) {
    FieldSolverOptions options;
    options.strength = strength;
    options.evaluations = 200;
    const FieldSolution solution = solveField(layout, air, points, options);
    EXPECT_GT(solution.error, error) << strength;
    EXPECT_GT(solution.scale, 1.2 * scale) << strength;
    error = solution.error;
    scale = solution.scale;
  }
}

/// Judged by blurred pressures, as skin feels them, a field is better if it was solved for these.
TEST_F(FieldSolver, BlurFavoursWhatSkinCanTellApart) {
  double sharp_error = 0.0, blurred_error = 0.0;
  for (unsigned seed = 20; seed < 24; ++seed) {
    const auto points = targets(palm(seed, 0.004));
    FieldSolverOptions sharp, blurred;
    sharp.evaluations = blurred.evaluations = 100;
    sharp.strength = blurred.strength = 0.0;
    blurred.blur = 0.006;
    sharp_error += objective(points, solveField(layout, air, points, sharp).drives, blurred);
    blurred_error += objective(points, solveField(layout, air, points, blurred).drives, blurred);
  }
  EXPECT_LT(blurred_error, sharp_error);
}

TEST_F(FieldSolver, WeightsFavourWhatCounts) {
  auto points = targets(palm(30, 0.004));
  double middle = 0.0;
  for (const FocalPoint& point : points) middle += point.position.x() / static_cast<double>(points.size());
  const auto errorOnTheRight = [&](const FieldSolution& solution) {
    std::vector<double> wanted, given;
    for (std::size_t m = 0; m < points.size(); ++m) {
      if (points[m].position.x() < middle) continue;
      wanted.push_back(solution.wanted[m]);
      given.push_back(solution.on_skin[m]);
    }
    return fieldFit(wanted, given).error;
  };
  const double even = errorOnTheRight(solveField(layout, air, points));
  for (FocalPoint& point : points) point.weight = point.position.x() < middle ? 0.05 : 1.0;
  EXPECT_LT(errorOnTheRight(solveField(layout, air, points)), even);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::field_solver_test
