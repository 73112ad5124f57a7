#include "clay/skin_path.h"

#include <gtest/gtest.h>

namespace tactile_clay::clay::skin_path_test {
namespace {

using Vector = Eigen::Vector3f;

constexpr double period = 1.0 / 60.0;

/// One sample, at x, that moves along x.
Skin sampleAt(float x, double velocity) {
  Skin skin;
  skin.position = {Vector(x, 0.0f, 0.0f)};
  skin.normal = {Vector::UnitZ()};
  skin.velocity = {Vector(static_cast<float>(velocity), 0.0f, 0.0f)};
  return skin;
}

/// Place of the sample at the start of the frame.
float startOf(const Skin& skin, double duration) {
  return skin.position[0].x() - static_cast<float>(duration) * skin.velocity[0].x();
}

/// Frames that are late, and samples whose stamps are hardly apart, since they came in a burst.
TEST(SkinPath, AFrameBeginsWhereTheOneBeforeEnded) {
  SkinPath path;
  path.add(sampleAt(0.0f, 0.0), 0.0);
  path.frame(period);
  double stamp = 0.0;
  float x = 0.0f, left_at = 0.0f;
  int count = 0;
  for (const double since : {1.0, 1.0, 3.0, 0.001, 0.02, 1.0, 0.5, 0.001, 1.0}) {
    const float step = 0.004f + 0.001f * static_cast<float>(++count % 3);
    x += step;
    stamp += since * period;
    path.add(sampleAt(x, step / (since * period)), stamp);
    if (count % 3 == 2) continue;  // overtaken by the next
    const double duration = (count % 2 == 0 ? 0.75 : 1.25) * period;
    const Skin skin = path.frame(duration);
    EXPECT_EQ(skin.position[0].x(), x);
    EXPECT_NEAR(startOf(skin, duration), left_at, 1e-5f) << count;
    left_at = x;
  }
}

TEST(SkinPath, RestsWhereNoSampleComes) {
  SkinPath path;
  path.add(sampleAt(0.1f, 0.3), period);
  path.frame(period);
  EXPECT_EQ(path.frame(period).velocity[0], Vector(Vector::Zero()));
  EXPECT_EQ(path.frame(period).position[0].x(), 0.1f);
}

TEST(SkinPath, AFrameOfNoTimeLeavesTheWayToTheNext) {
  SkinPath path;
  path.add(sampleAt(0.1f, 0.3), 0.0);
  path.add(sampleAt(0.105f, 0.3), period);
  EXPECT_EQ(path.frame(0.0).velocity[0], Vector(Vector::Zero()));
  EXPECT_NEAR(startOf(path.frame(0.5 * period), 0.5 * period), 0.105 - 0.3 * period, 1e-6);
}

/// A sample was lost on its way: the time since the sample before is longer than the time of the velocity.
TEST(SkinPath, GoesNoFartherThanTheSkinDid) {
  SkinPath path;
  path.add(sampleAt(0.0f, 0.0), period);
  path.frame(period);
  path.add(sampleAt(0.008f, 0.004 / (0.001 * period)), 3.0 * period);
  EXPECT_GT(startOf(path.frame(period), period), -0.0101f);  // by what skin may withdraw
}

/// If a hand is replaced or another is added, the samples before are no part of its way; the velocity in the
/// message is used. A hand that jumped has velocity 0 there.
TEST(SkinPath, OtherSamplesHaveNoPast) {
  SkinPath path;
  path.add(sampleAt(0.0f, 1.0), 0.0);
  path.add(sampleAt(0.01f, 1.0), period);
  Skin two = sampleAt(0.3f, 0.0);
  for (auto* part : {&two.position, &two.normal, &two.velocity}) part->push_back(part->front());
  path.add(two, 2.0 * period);
  EXPECT_EQ(path.frame(period).velocity[0], Vector(Vector::Zero()));
  path.add({}, 3.0 * period);
  EXPECT_EQ(path.frame(period).size(), 0U);
}

}  // namespace
}  // namespace tactile_clay::clay::skin_path_test
