#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "field_solver_fixture.h"
#include "support/error_of.h"
#include "ultrasound/field_solver.h"

namespace tactile_clay::ultrasound::field_solver_limits_test {
namespace {

TEST_F(FieldSolver, GivesNoMoreThanIsWanted) {
  auto points = targets(fingers(7, 2, 0.004));
  for (FocalPoint& point : points) point.intensity *= 0.2;
  const FieldSolution solution = solveField(layout, air, points);
  EXPECT_LE(solution.scale, 1.0 + 1e-5);
  EXPECT_GT(solution.scale, 0.8) << "for so little is there";
  for (const float amplitude : solution.drives[0].amplitude)
    EXPECT_EQ(amplitude, solution.drives[0].amplitude[0]);

  FieldSolverOptions options;
  options.amplitude = 0.3;
  options.amplitude_levels = 8;
  const FieldSolution weak = solveField(layout, air, points, options);
  EXPECT_FLOAT_EQ(weak.drives[0].amplitude[0] * 8.0f, std::round(weak.drives[0].amplitude[0] * 8.0f));
  EXPECT_LE(weak.drives[0].amplitude[0], 0.3f);
  EXPECT_GT(weak.drives[0].amplitude[0], 0.0f);
}

TEST_F(FieldSolver, FollowsSkinThatMoves) {
  const auto skin = fingers(8, 3, 0.004);
  std::vector<Drive> before;
  double error = 0.0, converged = 0.0;
  for (int frame = 0; frame < 20; ++frame) {  // 0.1 m/s at 60 frames a second
    auto moved = skin;
    for (auto& sample : moved)
      sample.position += Eigen::Vector3f(0.001f, 0.0005f, 0.0012f) * static_cast<float>(frame);
    const FieldSolution solution = solveField(layout, air, targets(moved), {}, before);
    before = solution.drives;
    if (frame % 5 != 4) continue;
    error += solution.error;
    FieldSolverOptions all;
    all.evaluations = 500;
    converged += solveField(layout, air, targets(moved), all).error;
  }
  EXPECT_LT(error, 1.15 * converged);
}

TEST_F(FieldSolver, StartsAnewWhereTheFieldBeforeIsOfNoUse) {
  const auto points = targets(fingers(9, 2, 0.004));
  const FieldSolution fresh = solveField(layout, air, points);
  FieldSolution lost = solveField(layout, air, points, {}, randomDrives(1, 6));
  EXPECT_LT(lost.error, 0.6) << "one frame";
  lost = solveField(layout, air, points, {}, lost.drives);
  EXPECT_LT(lost.error, 1.2 * fresh.error) << "and the next";
}

TEST_F(FieldSolver, KeepsToThePhasesOfTheDevice) {
  const auto points = targets(fingers(10, 3, 0.004));
  const double exact = solveField(layout, air, points).error;
  for (const int levels : {16, 32}) {
    FieldSolverOptions options;
    options.phase_levels = levels;
    const FieldSolution solution = solveField(layout, air, points, options);
    for (const float phase : solution.drives[0].phase) {
      const double level = phase / (2.0 * M_PI) * levels;
      EXPECT_NEAR(level, std::round(level), 1e-4);
      EXPECT_TRUE(phase >= 0.0f && phase < 6.2832f) << phase;
    }
    EXPECT_LT(solution.error, exact + 0.02);
  }
  FieldSolverOptions options;
  options.max_phase_change = 0.3;
  const std::vector<Drive> before = randomDrives(1, 2);
  const FieldSolution limited = solveField(layout, air, points, options, before);
  for (std::size_t n = 0; n < layout.size(); ++n)
    EXPECT_LE(std::abs(std::remainder(limited.drives[0].phase[n] - before[0].phase[n], 2.0 * M_PI)),
              0.3 + 1e-4);
}

TEST_F(FieldSolver, RepeatsItselfToTheBit) {
  const auto points = targets(fingers(11, 4, 0.004));
  const auto before = randomDrives(1, 3);
  const FieldSolution once = solveField(layout, air, points, {}, before);
  const FieldSolution again = solveField(layout, air, points, {}, before);
  EXPECT_EQ(once.drives[0].phase, again.drives[0].phase);
  EXPECT_EQ(once.drives[0].amplitude, again.drives[0].amplitude);
}

TEST_F(FieldSolver, IsSilentWhereNothingIsWantedOrCanBeHad) {
  FocalPoint bare, behind;
  bare.position = {0, 0, 0.2};
  behind.position = {0, 0, -0.1};
  behind.intensity = 1.0;
  for (const std::vector<FocalPoint>& points : {std::vector<FocalPoint>{}, {bare}, {behind}}) {
    const FieldSolution solution = solveField(layout, air, points);
    ASSERT_EQ(solution.drives.size(), 1u);
    for (const float amplitude : solution.drives[0].amplitude) EXPECT_EQ(amplitude, 0.0f);
    EXPECT_EQ(solution.scale, 0.0);
  }
}

TEST_F(FieldSolver, RefusesWhatIsOutOfRange) {
  FocalPoint point;
  point.id = 5;
  point.position = {0, 0, 0.2};
  point.intensity = 1.5;
  EXPECT_EQ(errorOf<std::invalid_argument>([&] { solveField(layout, air, {point}); }),
            "field solver: intensity of target 5: expected a number from 0 to 1, got 1.5");
  point.intensity = 0.5;
  point.position.x() = std::nan("");
  EXPECT_EQ(errorOf<std::invalid_argument>([&] { solveField(layout, air, {point}); }),
            "field solver: position of target 5 is not finite");
  point.position.x() = 0.0;
  point.weight = -1.0;
  EXPECT_EQ(errorOf<std::invalid_argument>([&] { solveField(layout, air, {point}); }),
            "field solver: weight of target 5: expected a finite number of at least 0, got -1");
  point.weight = 1.0;
  FieldSolverOptions options;
  options.blur = 0.2;
  EXPECT_EQ(errorOf<std::invalid_argument>([&] { solveField(layout, air, {point}, options); }),
            "field solver: blur (m): expected a number from 0 to 0.1, got 0.2");
  options.blur = 0.0;
  options.patterns = 3;
  EXPECT_EQ(errorOf<std::invalid_argument>([&] { solveField(layout, air, {point}, options); }),
            "field solver: patterns is 3, expected 1, 2, 4 or 8");
  EXPECT_NE(errorOf<std::invalid_argument>([&] {
              solveField(layout, air, {point}, {}, {Drive{{1.0f}, {1.0f}}});
            }).find("expected 256"),
            std::string::npos);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::field_solver_limits_test
