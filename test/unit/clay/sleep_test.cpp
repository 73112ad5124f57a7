#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "clay/clay.h"
#include "clay/sculpture.h"
#include "support/setups.h"

namespace tactile_clay::clay::sleep_test {
namespace {

constexpr double spacing = 0.005;
constexpr std::size_t size = 5 * 5 * 5;  // particles of a block

/// Blocks in a row, 60 mm apart, on the ground.
Clay blocks(int count, bool sleeping = true) {
  std::vector<InitialParticle> particles;
  for (int k = 0; k < count; ++k)
    for (const InitialParticle& p : block(5, 5, 5, spacing, {0.06 * k, 0.0, 0.0})) particles.push_back(p);
  ClayConfig config;
  config.spacing = spacing;
  config.threads = 1;
  config.sleeping = sleeping;
  return Clay(config, {Material()}, particles);
}

void run(Clay& clay, double seconds, const std::vector<Solid>& solids = {ground()}) {
  for (int k = 0; k < std::lround(60.0 * seconds); ++k) clay.advance({}, solids, 1.0 / 60.0);
}

/// A flat finger that presses 8 mm into the first block and leaves it again within 0.8 s.
void press(Clay& clay) {
  for (int k = 1; k <= 48; ++k) {
    const double way = 0.02 * std::sin(k * M_PI / 48.0), before = 0.02 * std::sin((k - 1) * M_PI / 48.0);
    const Eigen::Vector3d velocity(0.0, 0.0, -60.0 * (way - before));
    clay.advance(samplePlane({0.0, 0.0, 0.037 - way}, -Eigen::Vector3d::UnitZ(), 0.006, 0.003, velocity),
                 {ground()}, 1.0 / 60.0);
  }
}

TEST(Sleep, ClayAtRestSleepsAndPressesAsBefore) {
  Clay clay = blocks(2);
  run(clay, 0.2);
  EXPECT_EQ(clay.statistics().awake, 2 * size);
  run(clay, 1.8);
  EXPECT_EQ(clay.statistics().awake, 0u);
  const double weight = 9.81 * totalMass(clay.particles());
  EXPECT_NEAR(clay.solidForces()[0].z(), -weight, 1e-3 * weight);
  EXPECT_GT(clay.statistics().bonds, 1000u);
}

TEST(Sleep, OnlyWhatIsTouchedWakes) {
  Clay clay = blocks(3);
  run(clay, 2.0);
  const VectorField before = clay.particles().position;
  press(clay);
  EXPECT_EQ(clay.statistics().awake, size);
  const std::size_t others = 2 * size * sizeof(before[0]);
  EXPECT_EQ(std::memcmp(&before[size], &clay.particles().position[size], others), 0);
  EXPECT_GT((clay.particles().position.at(size - 13) - before.at(size - 13)).norm(), 0.5 * spacing);
  run(clay, 3.0);
  EXPECT_EQ(clay.statistics().awake, 0u);
}

/// Sleeping changes the final shape by less than a tenth of a spacing.
TEST(Sleep, ShapesStayWhatTheyAre) {
  Clay with = blocks(2), without = blocks(2, false);
  for (Clay* clay : {&with, &without}) {
    run(*clay, 2.0);
    press(*clay);
    run(*clay, 3.0);
    press(*clay);
    run(*clay, 3.0);
  }
  EXPECT_EQ(with.statistics().awake, 0u);
  EXPECT_EQ(without.statistics().awake, 2 * size);
  float worst = 0.0f;
  for (std::size_t i = 0; i < 2 * size; ++i)
    worst = std::max(worst, (with.particles().position.at(i) - without.particles().position.at(i)).norm());
  EXPECT_LT(worst, 0.1 * spacing);
}

TEST(Sleep, WhatFallsOnItWakesIt) {
  auto particles = block(5, 5, 5, spacing);
  for (InitialParticle p : block(5, 5, 5, spacing, {0.0, 0.0, 0.05})) {
    p.velocity = {0.0f, 0.0f, 6.0f};
    particles.push_back(p);
  }
  ClayConfig config;
  config.spacing = spacing;
  config.threads = 1;
  config.world = 2.5;
  Clay clay(config, {Material()}, particles);
  run(clay, 1.2);  // back at 1.22 s, at 6 m/s
  EXPECT_EQ(clay.statistics().awake, size);
  const float top = clay.particles().position.at(size - 1).z();
  run(clay, 0.1);
  EXPECT_EQ(clay.statistics().awake, 2 * size);
  EXPECT_GT(std::abs(clay.particles().position.at(size - 1).z() - top), 0.2 * spacing);
}

TEST(Sleep, MovedSolidsWakeIt) {
  {
    Clay clay = blocks(2);
    run(clay, 2.0);
    // the ground is gone
    run(clay, 0.1, {});
    EXPECT_EQ(clay.statistics().awake, 2 * size);
    EXPECT_NEAR(clay.particles().velocity.at(0).z(), -0.981, 0.05);
  }
  {
    Clay clay = blocks(2);
    run(clay, 2.0);
    // the ground jumps down
    Solid lower = ground();
    lower.pose.translation().z() -= 0.03;
    run(clay, 0.05, {lower});
    EXPECT_EQ(clay.statistics().awake, 2 * size);
  }
  {
    Clay clay = blocks(2);
    run(clay, 2.0);
    // a wall comes at the first block
    Solid wall;
    wall.size = {0.005, 0.05, 0.05};
    for (int k = 0; k < 60; ++k) {
      wall.pose.translation() = Eigen::Vector3d(-0.04 + 0.03 * k / 60.0, 0.0, 0.05);
      wall.linear_velocity = {0.03, 0.0, 0.0};
      clay.advance({}, {ground(), wall}, 1.0 / 60.0);
    }
    EXPECT_EQ(clay.statistics().awake, size);
    EXPECT_GT(clay.particles().position.at(0).x(), -0.004);
  }
}

/// A sculpture of sleeping clay, restored in clay that does not sleep, or woken explicitly: it is awake and
/// stays in its place.
TEST(Sleep, IsWokenByASculpture) {
  Clay asleep = blocks(2);
  run(asleep, 2.0);
  ASSERT_EQ(asleep.statistics().awake, 0u);
  const float top = asleep.particles().position.at(size - 1).z();
  for (const bool sleeping : {false, true}) {
    Clay clay = blocks(2, sleeping);
    clay.restore(sleeping ? woken(asleep.sculpture()) : asleep.sculpture());
    run(clay, 0.1);
    EXPECT_EQ(clay.statistics().awake, 2 * size);
    EXPECT_NEAR(clay.particles().position.at(size - 1).z(), top, 0.01 * spacing);
  }
}

/// Saved with one block asleep and one pressed; the pressed one wakes the other in the continuation.
TEST(Sleep, IsSaved) {
  const std::string file = testing::TempDir() + "sleep_test.clay";
  const auto go_on = [](Clay& clay) {
    press(clay);
    for (int k = 0; k < 30; ++k) {
      const Eigen::Vector3d velocity(0.0, 0.0, -0.1);
      clay.advance(samplePlane({0.06, 0.0, 0.04 - 0.1 * (k + 1) / 60.0}, -Eigen::Vector3d::UnitZ(), 0.006,
                               0.003, velocity),
                   {ground()}, 1.0 / 60.0);
    }
  };
  Clay whole = blocks(2);
  run(whole, 2.0);
  press(whole);
  ASSERT_EQ(whole.statistics().awake, size);
  save(whole.sculpture(), file);
  go_on(whole);

  Clay continued = blocks(2);
  continued.restore(loadSculpture(file));
  std::remove(file.c_str());
  go_on(continued);
  const VectorField &a = whole.particles().position, &b = continued.particles().position;
  EXPECT_EQ(std::memcmp(&a[0], &b[0], a.size() * sizeof(a[0])), 0);
  EXPECT_EQ(whole.statistics().awake, continued.statistics().awake);
  EXPECT_EQ(whole.statistics().bonds, continued.statistics().bonds);
}

}  // namespace
}  // namespace tactile_clay::clay::sleep_test
