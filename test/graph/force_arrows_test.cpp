#include "rviz_plugins/force_arrows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactile_clay::rviz_plugins {
namespace {

using Eigen::Vector3f;

Vector3f sumOf(const std::vector<PlacedForce>& forces) {
  Vector3f sum = Vector3f::Zero();
  for (const PlacedForce& one : forces) sum += one.force;
  return sum;
}

TEST(ForceArrows, ForcesOfACellAreAddedUpAtTheirMean) {
  const std::vector<PlacedForce> forces = {{Vector3f(0.001f, 0.0f, 0.0f), Vector3f(0.0f, 0.0f, -3.0f)},
                                           {Vector3f(0.005f, 0.0f, 0.0f), Vector3f(0.0f, 0.0f, -1.0f)},
                                           {Vector3f(-0.001f, 0.0f, 0.0f), Vector3f(0.5f, 0.0f, 0.0f)}};
  const std::vector<PlacedForce> sums = gathered(forces, 0.01f);
  ASSERT_EQ(sums.size(), 2U);
  EXPECT_TRUE(sums[0].at.isApprox(Vector3f(-0.001f, 0.0f, 0.0f)));
  EXPECT_TRUE(sums[1].at.isApprox(Vector3f(0.002f, 0.0f, 0.0f)));
  EXPECT_TRUE(sums[1].force.isApprox(Vector3f(0.0f, 0.0f, -4.0f)));
  EXPECT_TRUE(sumOf(sums).isApprox(sumOf(forces)));
  EXPECT_EQ(gathered(forces, 0.0f).size(), 3U);
}

TEST(ForceArrows, WhatIsNotFiniteOrZeroIsLeftOut) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<PlacedForce> forces = {{Vector3f(nan, 0.0f, 0.0f), Vector3f::UnitX()},
                                           {Vector3f::Zero(), Vector3f(0.0f, nan, 0.0f)},
                                           {Vector3f::Zero(), Vector3f::Zero()},
                                           {Vector3f::Constant(1e30f), Vector3f::UnitX()}};
  EXPECT_EQ(gathered(forces, 0.01f).size(), 1U);
  EXPECT_EQ(gathered(forces, 0.0f).size(), 1U);
}

TEST(ForceArrows, TheTipIsAtTheContactAndTheLengthInProportion) {
  surface::TriangleMesh mesh;
  const Vector3f at(0.1f, 0.2f, 0.3f);
  const ArrowLook look{0.02f, 0.003f};
  addArrow(mesh, {at, Vector3f(0.0f, 0.0f, -2.0f)}, look);
  ASSERT_FALSE(mesh.triangles.empty());
  float lowest = 1.0f, highest = 0.0f, widest = 0.0f;
  for (const Vector3f& corner : mesh.position) {
    lowest = std::min(lowest, corner.z());
    highest = std::max(highest, corner.z());
    widest = std::max(widest, (corner - at).head<2>().norm());
  }
  EXPECT_NEAR(lowest, at.z(), 1e-6);
  EXPECT_NEAR(highest, at.z() + 0.04f, 1e-6);
  EXPECT_LT(widest, 0.005f);
  // Closed and turned outwards: a cylinder and a cone with ten sides.
  const double ten_sides = 5.0 * std::sin(0.2 * M_PI), shaft = 0.0015, head = 2.4 * shaft, tip = 0.009;
  EXPECT_NEAR(surface::volumeOf(mesh), ten_sides * (shaft * shaft * (0.04 - tip) + head * head * tip / 3.0),
              1e-9);
}

TEST(ForceArrows, ShortArrowsAreThin) {
  surface::TriangleMesh mesh;
  addArrow(mesh, {Vector3f::Zero(), Vector3f(0.1f, 0.0f, 0.0f)}, {0.02f, 0.003f});  // 2 mm
  for (const Vector3f& corner : mesh.position) EXPECT_LT(std::hypot(corner.y(), corner.z()), 0.0005f);
  mesh = {};
  addArrow(mesh, {Vector3f::Zero(), Vector3f::Zero()}, {});
  EXPECT_TRUE(mesh.triangles.empty());
}

}  // namespace
}  // namespace tactile_clay::rviz_plugins
