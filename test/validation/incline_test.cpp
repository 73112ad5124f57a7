#include <gtest/gtest.h>

#include "scene/robot_model.h"
#include "scene/scene.h"
#include "scene/solids.h"
#include "support/setups.h"

/// Fig. 2 of the paper ("Natural Tactile Interaction with Virtual Clay"): a block is set down on an incline.
/// With all constraints it stops; without friction it slides, without viscosity it flows and fractures,
/// without bonds it creeps.
namespace tactile_clay::clay::incline_test {
namespace {

constexpr double slope = 20.0 * M_PI / 180.0, g = 9.81;

/// What happened to a block in 1.5 s.
struct Outcome {
  double first_height = 0.0;     // m, of the top above the incline, as if set down without a drop
  double height = 0.0;           // m, at the end
  double mean_height = 0.0;      // m, of the centre of mass, at the end
  double spread = 0.0;           // m, from end to end down the incline
  double mean_speed = 0.0;       // m/s, at the end
  double slide_after_1s = 0.0;   // m/s, of the centre of mass
  double height_after_1s = 0.0;  // m
  double acceleration = 0.0;     // m/s^2, down the incline, from 0.25 to 0.5 s
  double liveliest = 0.0;        // m/s, largest internal speed after the impact (0.05 s)
  double bonds_left = 0.0;       // share of the first ones
};

Outcome simulate(const std::string& name, Budget budget) {
  scene::Scene scene = scene::loadScene(name, TACTILE_CLAY_SHARE);
  scene.config.budget = budget;
  scene.config.threads = 2;
  const scene::Solids solids(scene::loadRobotModel(scene.urdf), scene.motions);
  Clay clay(scene.config, scene.materials, scene.particles);
  const Eigen::Vector3d up(std::sin(slope), 0.0, std::cos(slope)),
      down(std::cos(slope), 0.0, -std::sin(slope));
  const auto slide = [&] { return down.dot(momentum(clay.particles())) / totalMass(clay.particles()); };

  Outcome o;
  const auto [low, high] = extent(clay.particles(), up);
  o.first_height = high - low + 0.5 * scene.config.spacing;
  double early = 0.0, first_bonds = 0.0;
  for (int k = 1; k <= 90; ++k) {
    clay.advance({}, solids.solids(), solids.motion(), scene.config.frame);
    if (k == 1) first_bonds = static_cast<double>(clay.statistics().bonds);
    if (k > 3) o.liveliest = std::max(o.liveliest, internalSpeed(clay.particles()));
    if (k == 15) early = slide();
    if (k == 30) o.acceleration = (slide() - early) / 0.25;
    if (k == 60) {
      o.slide_after_1s = slide();
      o.height_after_1s = extent(clay.particles(), up).second;
    }
  }
  o.height = extent(clay.particles(), up).second;
  o.mean_height = up.dot(centreOfMass(clay.particles()));
  const auto [above, below] = extent(clay.particles(), down);
  o.spread = below - above;
  o.mean_speed = meanSpeed(clay.particles());
  o.bonds_left = first_bonds > 0.0 ? static_cast<double>(clay.statistics().bonds) / first_bonds : 0.0;
  return o;
}

class Incline : public ::testing::TestWithParam<std::pair<int, int>> {
 protected:
  Budget budget() const { return {GetParam().first, GetParam().second}; }
};

TEST_P(Incline, TheFullModelStopsAndKeepsItsShape) {
  const Outcome full = simulate("incline", budget());
  EXPECT_LT(full.mean_speed, 1e-3);
  EXPECT_GE(full.height, 0.9 * full.first_height);
  EXPECT_GE(full.bonds_left, 0.95);
}

TEST_P(Incline, WithoutFrictionItSlides) {
  const Outcome slippery = simulate("incline_no_friction", budget());
  EXPECT_NEAR(slippery.acceleration, g * std::sin(slope), 0.05 * g * std::sin(slope));
}

TEST_P(Incline, WithoutViscosityItFlowsAndFractures) {
  const Outcome full = simulate("incline", budget()), inviscid = simulate("incline_no_viscosity", budget());
  EXPECT_GT(inviscid.liveliest, 2.0 * full.liveliest);      // what the impact sets going is not damped,
  EXPECT_LT(inviscid.bonds_left, full.bonds_left - 0.1);    // tears bonds apart,
  EXPECT_GT(inviscid.spread, 2.0 * full.spread);            // scatters pieces
  EXPECT_LT(inviscid.mean_height, 0.9 * full.mean_height);  // and lets the rest collapse
}

TEST_P(Incline, WithoutBondsItCreeps) {
  const Outcome full = simulate("incline", budget()), loose = simulate("incline_no_bonds", budget());
  EXPECT_GT(loose.slide_after_1s, 10.0 * std::abs(full.slide_after_1s));
  EXPECT_GT(loose.slide_after_1s, 1e-3);
  EXPECT_LT(loose.height, 0.8 * full.height);
  EXPECT_LT(loose.height, loose.height_after_1s - 1e-3);  // and it has not stopped falling
}

std::string nameOf(const ::testing::TestParamInfo<std::pair<int, int>>& tested) {
  return std::to_string(tested.param.first) + "x" + std::to_string(tested.param.second);
}
INSTANTIATE_TEST_SUITE_P(Fig2, Incline, ::testing::Values(std::pair{4, 8}, std::pair{8, 16}), nameOf);

}  // namespace
}  // namespace tactile_clay::clay::incline_test
