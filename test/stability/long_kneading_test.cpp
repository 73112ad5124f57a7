// Minutes of kneading: the work per frame does not grow, and the clay stays clay. Work is counted, so that it
// is the same on every machine; measure_kneading measures it in milliseconds.
#include <gtest/gtest.h>

#include <vector>

#include "scene/robot_model.h"
#include "scene/scene.h"
#include "tools/long_kneading.h"

namespace tactile_clay::tools {
namespace {

TEST(LongKneading, TheThirdMinuteCostsNoMoreThanTheSecond) {
  const std::string package = TACTILE_CLAY_SOURCE_DIR;
  scene::Scene scene = scene::loadScene("kindergarten", package, 0.0);
  scene.config.budget = scene::loadQuality("balanced", package);
  const scene::Solids solids(scene::loadRobotModel(scene.urdf), scene.motions);
  const std::vector<HandSample> hands = handSamples("knead", 0.0, scene.config.spacing, package);
  LongKneading how;
  how.duration = 180.0;
  how.stretch = 60.0;
  std::vector<Stretch> minutes;
  kneadLong(scene, solids, hands, how, [&](const Stretch& minute) {
    minutes.push_back(minute);
    std::printf(
        "  %3.0f s: %.2f ms, %.0f awake, %.2f iterations, %.2f crumbs, %.3f bonds, %.2f neighbours, %.1f "
        "cm^3\n",
        minute.end, minute.ms, minute.awake, minute.iterations, minute.crumbs, minute.bonds,
        minute.neighbours, 1e6 * minute.volume);
  });
  ASSERT_EQ(minutes.size(), 3U);
  const Stretch &first = minutes[0], &second = minutes[1], &third = minutes[2];
  ASSERT_GT(first.awake, 100.0);
  ASSERT_GT(third.contacts, 10.0);
  // Number of particles that are solved, times iterations.
  EXPECT_LT(third.awake * third.iterations, 1.15 * second.awake * second.iterations);
  EXPECT_LT(third.contacts, 1.15 * second.contacts);
  EXPECT_LT(third.rounds, 1.15 * second.rounds);
  EXPECT_LT(third.memory, 1.02 * second.memory);
  EXPECT_NEAR(third.bonds / second.bonds, 1.0, 0.02);
  EXPECT_NEAR(third.neighbours / second.neighbours, 1.0, 0.02);
  EXPECT_NEAR(third.volume / first.volume, 1.0, 0.02);
  // No particle has left the scene, and there is no heap of crumbs that hands cannot gather.
  EXPECT_EQ(third.strays, 0U);
  EXPECT_LT(third.crumbs, 0.01 * static_cast<double>(scene.particles.size()));
}

}  // namespace
}  // namespace tactile_clay::tools
