#include "tools/clay_shape.h"

#include <gtest/gtest.h>

#include "support/setups.h"

namespace tactile_clay::tools::clay_shape_test {
namespace {

using Eigen::Vector3d;

constexpr double spacing = 0.005;  // m
const Vector3d gravity(0.0, 0.0, -9.81);

/// n^3 particles on a cubic lattice; its cubes, one around each particle, stand on `foot`.
clay::VectorField cube(int n, const Vector3d& foot = Vector3d::Zero(),
                       const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity()) {
  clay::VectorField position;
  position.resize(static_cast<std::size_t>(n) * n * n);
  std::size_t i = 0;
  for (const clay::InitialParticle& p : clay::block(n, n, n, spacing, foot, rotation))
    position.set(i++, p.position);
  return position;
}

double volumeInSpacings(const clay::VectorField& position) {
  return volumeOf(position, spacing) / std::pow(spacing, 3);
}

// Half the lattice on each side of a plane midway between two layers gives half the sum there: the surface
// lies half a spacing outside the outermost layer, and the block's faces bound n^3. Where the cells, half a
// spacing wide, fill the block, their outermost centres are a quarter of a spacing within a face. The sum
// there is 0.67 of the full one, so these cells count; 0.33 at the centres just outside, which do not; and by
// its product about 0.67^2 = 0.45 where two faces meet, so that the cells along edges do not: those are 12
// (2n - 2) + 8 cells of an eighth, which is 3n - 2.
TEST(Volume, OfABlockThatFillsCellsIsItsOwnButForTheCellsAlongEdges) {
  for (const int n : {2, 3, 8})
    EXPECT_NEAR(volumeInSpacings(cube(n, {0.0, 0.0, n % 2 == 0 ? 0.0 : 0.5 * spacing})),
                n * n * n - 3 * n + 2, 1e-3)
        << n;
}

TEST(Volume, IsTheSameOnEverySideOfTheOrigin) {
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.4, 0.4})
      for (const double z : {-0.3, 0.3})
        EXPECT_NEAR(volumeInSpacings(cube(4, {x, y, z})), 54.0, 1e-3) << x << ' ' << y << ' ' << z;
}

// A turned block cuts the cells in all ways, so that over a face the cells that count too much and too little
// cancel. What edges lose by their rounding remains: less than a square of half a spacing along each of the
// 12, which is 3n. To compare: were the surface where the clay is 0.55 as dense, it would lie 0.07 of a
// spacing (by the slope of the sum, 0.7 a spacing) deeper, and the block would lack another 0.07 * 6 n^2 =
// 0.42 n^2.
TEST(Volume, OfATurnedBlockLacksNoMoreThanItsEdges) {
  constexpr int n = 8;
  for (const double angle : {0.2, 0.4, 0.6, 0.8}) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(angle, Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
    const double volume = volumeInSpacings(cube(n, {0.01, 0.02, 0.03}, turn));
    EXPECT_GT(volume, n * n * n - 3 * n) << angle;
    EXPECT_LT(volume, n * n * n) << angle;
  }
}

TEST(Volume, OfALoneParticleIsNone) {
  EXPECT_EQ(volumeOf(cube(1), spacing), 0.0);  // 0.5 of the full sum is more than its own
}

/// A box whose top face is at z = `top`.
clay::Solid pedestal(double top, const Vector3d& half_extents) {
  clay::Solid solid;
  solid.shape = clay::Solid::Shape::box;
  solid.size = half_extents;
  solid.pose.translation().z() = top - half_extents.z();
  return solid;
}

constexpr double rounding = 1e-7;  // m, of positions below 1 m in single precision

TEST(Height, OfABlockIsItsLayers) {
  EXPECT_NEAR(heightOf(cube(6), {clay::ground()}, gravity, spacing), 6 * spacing, rounding);
  // From its top down, so that the highest particle comes first.
  const Eigen::Matrix3d over = Eigen::AngleAxisd(M_PI, Vector3d::UnitX()).toRotationMatrix();
  EXPECT_NEAR(heightOf(cube(6, {0.0, 0.0, 6 * spacing}, over), {clay::ground()}, gravity, spacing),
              6 * spacing, rounding);
}

TEST(Height, IsOverTheHighestSolidBelow) {
  const clay::VectorField block = cube(4, {0.0, 0.0, 0.05});
  EXPECT_NEAR(heightOf(block, {clay::ground()}, gravity, spacing), 0.05 + 4 * spacing, rounding);
  const clay::Solid solid = pedestal(0.05, {0.1, 0.1, 0.02});
  for (const auto& solids : {std::vector{clay::ground(), solid}, std::vector{solid, clay::ground()}})
    EXPECT_NEAR(heightOf(block, solids, gravity, spacing), 4 * spacing, rounding);
}

TEST(Height, IsNotOverWallsAndCeilings) {
  clay::Solid wall = pedestal(0.5, {0.01, 0.5, 0.3});
  wall.pose.translation().x() = 0.031;  // 1 mm beside a block of 40 mm
  clay::Solid ceiling = pedestal(0.5, {0.5, 0.5, 0.01});
  EXPECT_NEAR(heightOf(cube(8), {clay::ground(), wall, ceiling}, gravity, spacing), 8 * spacing, rounding);
  EXPECT_EQ(heightOf(cube(8), {wall, ceiling}, gravity, spacing), 0.0);
}

/// The direction of faces is judged in the world.
TEST(Height, IsOverASolidThatLiesOnItsSide) {
  clay::Solid slab = pedestal(0.0, {0.5, 0.1, 0.5});
  slab.pose.linear() = Eigen::AngleAxisd(0.5 * M_PI, Vector3d::UnitX()).toRotationMatrix();
  slab.pose.translation().z() = -0.1;  // its thin side is up now
  EXPECT_NEAR(heightOf(cube(5), {slab}, gravity, spacing), 5 * spacing, rounding);
}

/// On an incline it is measured across it, whatever the slope.
TEST(Height, OnAnInclineIsTheDistanceFromIt) {
  const double slope = 0.5;
  const clay::Solid incline = clay::ground(slope);
  EXPECT_NEAR(heightOf(cube(5, Vector3d::Zero(), incline.pose.linear()), {incline}, gravity, spacing),
              5 * spacing, rounding);
}

}  // namespace
}  // namespace tactile_clay::tools::clay_shape_test
