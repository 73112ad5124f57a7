#include <gtest/gtest.h>

#include "support/setups.h"

/// A column of liquid (no bonds, no friction) in a box.
namespace tactile_clay::clay::hydrostatics_test {
namespace {

constexpr double g = 9.81, spacing = 0.005;
constexpr int edge = 6, layers = 12;
constexpr double width = edge * spacing;

std::vector<Solid> box() {
  std::vector<Solid> solids{ground()};
  for (const Eigen::Vector3d& side : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(-1, 0, 0),
                                      Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, -1, 0)}) {
    Solid wall;
    wall.size = {0.2, 0.2, 0.2};
    wall.pose.translation() = (0.5 * width + 0.2) * side;
    solids.push_back(wall);
  }
  return solids;
}

class Column : public ::testing::TestWithParam<std::pair<int, int>> {};

TEST_P(Column, RestsOnTheFloorWithItsWeightAndPressesTheWallsByItsDepth) {
  ClayConfig config;
  config.budget = {GetParam().first, GetParam().second};
  config.threads = 2;
  Material liquid;
  liquid.stiffness = 0.0;
  liquid.friction = 0.0;
  liquid.viscosity = 20.0;
  Clay clay(config, {liquid}, block(edge, edge, layers, spacing));
  const auto solids = box();
  for (int k = 0; k < 120; ++k) clay.advance({}, solids, config.frame);
  // the mean over half a second: pressure waves of single steps cancel
  std::vector<Eigen::Vector3d> force(solids.size(), Eigen::Vector3d::Zero());
  double error = 0.0;
  for (int k = 0; k < 30; ++k) {
    clay.advance({}, solids, config.frame);
    for (std::size_t s = 0; s < solids.size(); ++s) force[s] += clay.solidForces()[s] / 30.0;
    error = std::max(error, clay.statistics().density_error_mean);
  }
  const double mass = totalMass(clay.particles()), weight = mass * g;
  EXPECT_NEAR(-force[0].z(), weight, 1e-3 * weight);
  const double height = mass / (liquid.density * width * width);
  const double thrust = 0.5 * liquid.density * g * height * height * width;  // of p = rho g (H - z)
  for (std::size_t s = 1; s < solids.size(); ++s)
    EXPECT_NEAR(force[s].head<2>().norm(), thrust, 0.15 * thrust);
  EXPECT_LT(error, 0.01);
}

/// Height M / (rho A). Without the density that solids add to the particles on them, the column packs by 15
/// %.
TEST_P(Column, KeepsItsVolume) {
  ClayConfig config;
  config.budget = {GetParam().first, GetParam().second};
  config.threads = 2;
  Material liquid;
  liquid.stiffness = 0.0;
  liquid.friction = 0.0;
  liquid.viscosity = 20.0;
  Clay clay(config, {liquid}, block(edge, edge, layers, spacing));
  const auto solids = box();
  for (int k = 0; k < 120; ++k) clay.advance({}, solids, config.frame);
  EXPECT_NEAR(2.0 * centreOfMass(clay.particles()).z(), layers * spacing, 0.03 * layers * spacing);
}

std::string nameOf(const ::testing::TestParamInfo<std::pair<int, int>>& tested) {
  return std::to_string(tested.param.first) + "x" + std::to_string(tested.param.second);
}
INSTANTIATE_TEST_SUITE_P(Hydrostatics, Column, ::testing::Values(std::pair{4, 8}, std::pair{8, 16}), nameOf);

/// For comparison a settled block of clay: bonded, sticking, and as heavy.
TEST(SettledClay, WeighsWhatItWeighs) {
  for (const Budget budget : {Budget{4, 8}, Budget{8, 16}}) {
    ClayConfig config;
    config.budget = budget;
    config.threads = 2;
    Clay clay(config, {Material()}, block(8, 8, 8, spacing, {0.0, 0.0, 0.01}));
    for (int k = 0; k < 60; ++k) clay.advance({}, {ground()}, config.frame);
    const double weight = g * totalMass(clay.particles());
    EXPECT_NEAR(-clay.solidForces()[0].z(), weight, 1e-3 * weight);
    EXPECT_LT(meanSpeed(clay.particles()), 1e-5);
  }
}

}  // namespace
}  // namespace tactile_clay::clay::hydrostatics_test
