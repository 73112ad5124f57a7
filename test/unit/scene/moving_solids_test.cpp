// Clay meets solids where they are in each step, whenever their motions start and end.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "clay/clay.h"
#include "scene/scene.h"
#include "scene/solids.h"

namespace tactile_clay::scene::moving_solids_test {
namespace {

const std::string share = TACTILE_CLAY_SHARE;
constexpr double frame = 1.0 / 60.0;  // s

/// Scene `press` with this motion of its plate.
struct Press {
  explicit Press(const std::vector<Motion>& motions, int iterations = clay::Budget().iterations)
      : scene(loadScene("press", share)), solids(readText(scene.urdf), motions) {
    EXPECT_EQ(solids.solids().front().name, "plate");
    scene.config.threads = 1;
    scene.config.budget.iterations = iterations;
    clay = std::make_unique<clay::Clay>(scene.config, scene.materials, scene.particles);
  }
  /// Upward force on the plate in a frame, N.
  double frameOn() {
    clay->advance({}, solids.solids(), solids.motion(), frame);
    return clay->solidForces().front().z();
  }
  Scene scene;
  Solids solids;
  std::unique_ptr<clay::Clay> clay;
};

double top(const clay::Clay& clay) {
  double highest = -1.0;
  for (std::size_t i = 0; i < clay.particles().size(); ++i)
    highest = std::max<double>(highest, clay.particles().position.at(i).z());
  return highest;
}

/// 0.17 s are 10.2 frames. When the velocity was constant for the whole last frame, the plate went on by 0.8
/// of a frame and then jumped back: 75 N at the peak and 34 N when it stood, instead of 60 and 60.
TEST(MovingSolids, APlateThatStopsWithinAFramePressesAsOneThatStopsAtItsEnd) {
  Press within({{"plate_joint", 0.2, -0.1, 0.17}}), whole({{"plate_joint", 0.2, -0.102, 10.0 * frame}});
  double max_within = 0.0, max_whole = 0.0, last_within = 0.0, last_whole = 0.0;
  for (int k = 0; k < 36; ++k) {
    max_within = std::max(max_within, last_within = within.frameOn());
    max_whole = std::max(max_whole, last_whole = whole.frameOn());
  }
  EXPECT_GT(last_whole, 30.0);
  EXPECT_NEAR(max_within, max_whole, 0.05 * max_whole);
  EXPECT_NEAR(last_within, last_whole, 0.03 * last_whole);
  EXPECT_NEAR(top(*within.clay), top(*whole.clay), 0.25e-3);
}

/// A motion that is shorter than a step still moves the solid by all of it, and the clay feels it: steps of
/// 1/15360 s give 64 N. A strain of two spacings in one step needs many iterations.
TEST(MovingSolids, MotionsShorterThanAStepAreNotLost) {
  Press jerky({{"plate_joint", 0.2015, -10.0, 0.0017}}, 64);
  double maximum = 0.0;
  for (int k = 0; k < 24; ++k) maximum = std::max(maximum, jerky.frameOn());
  EXPECT_GT(maximum, 20.0);
  EXPECT_NEAR(jerky.solids.joints(jerky.clay->time()).at("plate_joint"), -0.017, 1e-12);
  EXPECT_LT(top(*jerky.clay), 0.045 - 0.017);
}

/// Pressed, held and lifted: after that nothing touches the plate.
TEST(MovingSolids, PressHoldAndLift) {
  Press press({{"plate_joint", 0.1, -0.1, 0.12}, {"plate_joint", 0.3, 0.1, 0.1}});
  double held = 0.0, lifted = 0.0;
  for (int k = 0; k < 30; ++k) {
    const double force = press.frameOn();
    if (k == 16) held = force;
    lifted = force;
  }
  EXPECT_GT(held, 10.0);
  EXPECT_EQ(lifted, 0.0);
}

/// A cup with walls of 1 mm, tilted for three frames less a little, loses nothing through them.
TEST(MovingSolids, AThinCupThatIsTurnedFastKeepsItsLiquid) {
  const double wall = 0.001;  // m
  std::string cup =
      "<robot name='cup'><link name='world'/><joint name='tilt' type='revolute'><parent link='world'/>"
      "<child link='cup'/><axis xyz='0 1 0'/><limit lower='-3' upper='3' effort='1' velocity='20'/></joint>"
      "<link name='cup'>";
  const auto board = [&](double x, double y, double z, double a, double b, double c) {
    cup += "<collision><origin xyz='" + std::to_string(x) + " " + std::to_string(y) + " " +
           std::to_string(z) + "'/><geometry><box size='" + std::to_string(a) + " " + std::to_string(b) +
           " " + std::to_string(c) + "'/></geometry></collision>";
  };
  board(0.0, 0.0, -0.5 * wall, 0.042, 0.042, wall);
  for (const double side : {-1.0, 1.0}) {
    board(0.0205 * side, 0.0, 0.03, wall, 0.042, 0.06);
    board(0.0, 0.0205 * side, 0.03, 0.042, wall, 0.06);
  }
  const Solids solids(cup + "</link></robot>", {{"tilt", 0.2, 12.0, 3.0 * frame - 1e-4}});
  clay::Material honey;
  honey.viscosity = 1.0;
  honey.stiffness = 0.0;
  honey.friction = 0.1;
  std::vector<clay::InitialParticle> drink;
  for (int k = 0; k < 8 * 8 * 6; ++k) {
    const Eigen::Vector3f at(static_cast<float>(k % 8) - 3.5f, static_cast<float>(k / 8 % 8) - 3.5f,
                             static_cast<float>(k / 64) + 0.5f);
    drink.push_back({0.005f * at, Eigen::Vector3f::Zero()});
  }
  clay::ClayConfig config;
  config.threads = 1;
  clay::Clay clay(config, {honey}, drink);
  for (int k = 0; k < 22; ++k) {
    clay.advance({}, solids.solids(), solids.motion(), frame);
    const Eigen::AngleAxisd turn(-solids.joints(clay.time()).at("tilt"), Eigen::Vector3d::UnitY());
    for (std::size_t i = 0; i < clay.particles().size(); ++i) {
      const Eigen::Vector3d x = turn * clay.particles().position.at(i).cast<double>();
      if (x.z() > 0.06) continue;
      ASSERT_GT(x.z(), -wall) << "frame " << k;
      ASSERT_LT(x.head<2>().cwiseAbs().maxCoeff(), 0.02 + wall) << "frame " << k;
    }
  }
  EXPECT_NEAR(solids.joints(clay.time()).at("tilt"), 0.6, 0.002);
}

}  // namespace
}  // namespace tactile_clay::scene::moving_solids_test
