#include "ultrasound/field_maximum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "ultrasound/phase_solver.h"

namespace tactile_clay::ultrasound::field_maximum_test {
namespace {

using Points = std::vector<FocalPoint>;

/// Below the floor the pressures are those at the points, and nothing is searched where nothing can be found.
TEST(FieldMaximum, SearchesNoMoreThanItHasTo) {
  const ArrayLayout layout = arrayLayout("usx");
  const FieldMaximum maximum(layout, {}, {-0.2, -0.2, 0.05}, {0.2, 0.2, 0.4}, 2000.0);
  Points points(1);
  points[0].position = {0.02, 0.01, 0.2};
  points[0].intensity = 0.1;
  FieldMaximum::Effort effort;
  Drive drive = solvePhases(layout, {}, points).drive;
  const auto weak = maximum.find(drive, {points[0].position}, &effort);
  EXPECT_EQ(effort.evaluations, 1u);
  EXPECT_NEAR(weak.pressure, std::abs(pressureAt(layout, {}, drive, points[0].position)), 1e-9);
  points[0].intensity = 1.0;
  drive = solvePhases(layout, {}, points).drive;
  const auto strong = maximum.find(drive, {points[0].position}, &effort);
  EXPECT_GT(strong.pressure, 3400.0);
  EXPECT_LT((strong.position - points[0].position).norm(), 0.02);
  EXPECT_LT(effort.evaluations, 5000u);
  EXPECT_LE(effort.climbs, 12u);
  // For any drive: random phases at full drive, and a cap that all pressures exceed.
  const FieldMaximum low(layout, {}, {-0.2, -0.2, 0.05}, {0.2, 0.2, 0.4}, 10.0);
  std::mt19937 random(3);
  for (float& phase : drive.phase) phase = std::uniform_real_distribution<float>(0.0f, 6.28f)(random);
  low.find(drive, {points[0].position}, &effort);
  EXPECT_LT(effort.evaluations, 100000u);
}

TEST(FieldMaximum, SaysWhatIsWrong) {
  const ArrayLayout layout = arrayLayout("usx");
  const FieldMaximum maximum(layout, {}, {-0.2, -0.2, 0.05}, {0.2, 0.2, 0.4}, 2000.0);
  EXPECT_THROW(maximum.find({{0.0f}, {1.0f}}, {}), std::invalid_argument);
  EXPECT_THROW(FieldMaximum({}, {}, {0, 0, 0}, {1, 1, 1}, 1.0), std::invalid_argument);
  EXPECT_THROW(FieldMaximum(layout, {}, {0, 0, 0}, {1, 1, -1}, 1.0), std::invalid_argument);
  Drive silent{std::vector<float>(256, 0.0f), std::vector<float>(256, 0.0f)};
  EXPECT_EQ(maximum.find(silent, {{0, 0, 0.2}}).pressure, 0.0);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::field_maximum_test
