// Minutes of kneading: the work per frame does not grow, and the clay stays clay. Work is counted, so that it
// is the same on every machine; measure_kneading measures it in milliseconds.
#include <gtest/gtest.h>

#include <vector>

#include "scene/robot_model.h"
#include "scene/scene.h"
#include "tools/clay_shape.h"
#include "tools/long_kneading.h"

namespace tactile_clay::tools::long_kneading_test {
namespace {

/// The minutes of a kneading in lockstep.
std::vector<Stretch> minutesOf(const scene::Scene& scene, const std::string& which, int minutes) {
  const scene::Solids solids(scene::loadRobotModel(scene.urdf), scene.motions);
  const std::vector<HandSample> hands =
      handSamples(which, 0.0, scene.config.spacing, TACTILE_CLAY_SOURCE_DIR);
  LongKneading how;
  how.duration = 60.0 * minutes;
  how.stretch = 60.0;
  std::vector<Stretch> found;
  kneadLong(scene, solids, hands, how, [&](const Stretch& minute) {
    found.push_back(minute);
    std::printf("  %3.0f s: %.2f ms, %.0f awake, %.2f iterations, ", minute.end, minute.ms, minute.awake,
                minute.iterations);
    std::printf("%.2f crumbs, %.3f bonds, %.2f neighbours, %.1f cm^3\n", minute.crumbs, minute.bonds,
                minute.neighbours, 1e6 * minute.volume);
  });
  return found;
}

/// The third minute costs no more than the second, and the clay is still the clay of the start: squeezed
/// again and again from two sides, clay that does not keep its volume becomes loose inside (by 7.6 %
/// on the wheel).
void expectSteady(const std::string& scene_name, const std::string& quality, const std::string& hands) {
  const std::string package = TACTILE_CLAY_SOURCE_DIR;
  scene::Scene scene = scene::loadScene(scene_name, package, 0.0);
  scene.config.budget = scene::loadQuality(quality, package);
  const double at_start = volumeOf(
      clay::Clay(scene.config, scene.materials, scene.particles).particles().position, scene.config.spacing);
  const std::vector<Stretch> minutes = minutesOf(scene, hands, 3);
  ASSERT_EQ(minutes.size(), 3U);
  const Stretch &first = minutes[0], &second = minutes[1], &third = minutes[2];
  ASSERT_GT(first.awake, 100.0);
  ASSERT_GT(third.contacts, 10.0);
  // The hands still knead the clay: it has not left the place where they are.
  ASSERT_GT(third.touched, 1.0);
  EXPECT_GT(third.touched, 0.6 * second.touched);
  // Number of particles that are solved, times iterations.
  EXPECT_LT(third.awake * third.iterations, 1.15 * second.awake * second.iterations);
  EXPECT_LT(third.contacts, 1.15 * second.contacts);
  EXPECT_LT(third.rounds, 1.15 * second.rounds);
  EXPECT_LT(third.memory, 1.02 * second.memory);
  EXPECT_NEAR(third.bonds / second.bonds, 1.0, 0.02);
  EXPECT_NEAR(third.neighbours / second.neighbours, 1.0, 0.02);
  EXPECT_NEAR(third.volume / at_start, 1.0, 0.02);
  EXPECT_NEAR(third.volume / first.volume, 1.0, 0.02);
  // No particle has left the scene, and there is no heap of crumbs that hands cannot gather.
  EXPECT_EQ(third.strays, 0U);
  EXPECT_LT(third.crumbs, 3.0);
}

TEST(LongKneading, TheThirdMinuteOnTheTableCostsNoMoreThanTheSecond) {
  expectSteady("kindergarten", "balanced", "knead");
}

TEST(LongKneading, TheThirdMinuteOnTheWheelCostsNoMoreThanTheSecond) {
  expectSteady("potters_wheel", "fast", "cupping");
}

}  // namespace
}  // namespace tactile_clay::tools::long_kneading_test
