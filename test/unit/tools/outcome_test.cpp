#include "tools/outcome.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tactile_clay::tools::outcome_test {
namespace {

using Eigen::Vector3f;

constexpr double spacing = 0.005;  // m
constexpr double frame = 1.0 / 60.0;

Load load(const Eigen::Vector3d& left, const Eigen::Vector3d& right = Eigen::Vector3d::Zero()) {
  Load both;
  both << left, right;
  return both;
}

TEST(LoadMeans, AreOfSixFramesAndLeaveOutTheRest) {
  std::vector<TimedLoad> loads;
  for (int k = 0; k < 15; ++k) {
    const double force = k < 6 ? 2.0 : k % 3;  // N; the second six: 0, 1, 2, 0, 1, 2
    loads.push_back({frame, load({force, 0.0, 0.0}, {0.0, 0.0, -force})});
  }
  const std::vector<Load> means = meansOf(loads);
  ASSERT_EQ(means.size(), 2U);
  EXPECT_TRUE(means[0].isApprox(load({2.0, 0.0, 0.0}, {0.0, 0.0, -2.0}), 1e-12)) << means[0];
  EXPECT_TRUE(means[1].isApprox(load({1.0, 0.0, 0.0}, {0.0, 0.0, -1.0}), 1e-12)) << means[1];
}

TEST(LoadMeans, WeighSamplesByTheirDuration) {
  const std::vector<Load> means =
      meansOf({{0.06, load({1.0, 0.0, 0.0})}, {0.04, load({6.0, 0.0, 0.0})}, {0.5, load({0.0, 7.0, 0.0})}});
  ASSERT_EQ(means.size(), 2U);
  EXPECT_TRUE(means[0].isApprox(load({3.0, 0.0, 0.0}), 1e-12)) << means[0];  // (0.06 * 1 + 0.04 * 6) / 0.1
  EXPECT_TRUE(means[1].isApprox(load({0.0, 7.0, 0.0}), 1e-12)) << means[1];  // longer than 0.1 s by itself
}

clay::VectorField positions(const std::vector<Vector3f>& points) {
  clay::VectorField field;
  field.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) field.set(i, points[i]);
  return field;
}

Outcome reference() {
  Outcome o;
  o.position = positions({{0.0f, 0.0f, 0.01f}, {0.1f, -0.1f, 0.02f}});
  o.height = 0.04;
  o.force = {load({3.0, 0.0, 0.0}), load({0.0, 0.0, 0.0}, {0.0, 4.0, 0.0})};
  o.mean_force = 2.0;
  return o;
}

TEST(Compare, AnOutcomeHasNoErrorAgainstItself) {
  const Errors e = compare(reference(), reference(), spacing);
  EXPECT_EQ(e.displacement, 0.0);
  EXPECT_EQ(e.height, 0.0);
  EXPECT_EQ(e.force, 0.0);
  EXPECT_EQ(e.mean_force, 0.0);
}

TEST(Compare, DisplacementIsRootMeanSquareInSpacings) {
  Outcome o = reference();
  // 3 and 4 mm
  o.position = positions({{0.003f, 0.0f, 0.01f}, {0.1f, -0.1f, 0.016f}});
  EXPECT_NEAR(compare(o, reference(), spacing).displacement, std::sqrt((9.0 + 16.0) / 2.0) / 5.0, 1e-5);
}

TEST(Compare, HeightIsAShareOfTheReferenceWithItsSign) {
  Outcome o = reference();
  o.height = 0.044;
  EXPECT_NEAR(compare(o, reference(), spacing).height, 0.1, 1e-12);
  o.height = 0.03;
  EXPECT_NEAR(compare(o, reference(), spacing).height, -0.25, 1e-12);
}

TEST(Compare, ThereIsNoHeightErrorWhereTheReferenceHasNoHeight) {
  Outcome flat = reference();
  flat.height = 0.0;
  EXPECT_TRUE(std::isnan(compare(reference(), flat, spacing).height));
}

TEST(Compare, ForceIsRootMeanSquareOfTheErrorOverThatOfTheReference) {
  Outcome o = reference();
  o.force[0] += load({0.0, 0.6, 0.0});                    // across, which no norm of the load would tell
  o.force[1] += load({0.0, 0.0, 0.0}, {0.0, -0.8, 0.0});  // on the other hand, at another time
  EXPECT_NEAR(compare(o, reference(), spacing).force, std::sqrt((0.36 + 0.64) / (9.0 + 16.0)), 1e-12);
}

TEST(Compare, MeanForceIsAShareOfTheReferenceWithItsSign) {
  Outcome o = reference();
  o.mean_force = 1.9;
  EXPECT_NEAR(compare(o, reference(), spacing).mean_force, -0.05, 1e-12);
}

TEST(Compare, ThereIsNoForceErrorWhereTheReferenceTouchesNothing) {
  Outcome untouched = reference();
  untouched.force = {load({0.0, 0.0, 0.0}), load({0.0, 0.0, 0.0})};
  untouched.mean_force = 0.0;
  const Errors e = compare(reference(), untouched, spacing);
  EXPECT_TRUE(std::isnan(e.force));
  EXPECT_TRUE(std::isnan(e.mean_force));
}

TEST(Greatest, IsOfEachErrorBySize) {
  const Errors e = max({0.1, -0.4, 0.3, 0.2}, {0.2, 0.3, 0.1, -0.5});
  EXPECT_EQ(e.displacement, 0.2);
  EXPECT_EQ(e.height, 0.4);
  EXPECT_EQ(e.force, 0.3);
  EXPECT_EQ(e.mean_force, 0.5);
}

}  // namespace
}  // namespace tactile_clay::tools::outcome_test
