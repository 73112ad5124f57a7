#include <gtest/gtest.h>

#include <random>

#include "contacts.h"
#include "ultrasound/focal_points.h"

namespace tactile_clay::ultrasound::focal_points_over_time_test {
namespace {

TEST(FocalPoints, KeepTheirIdsWhileContactsMove) {
  FocalPointRenderer renderer;
  const auto frame = [](int t) {
    const float x = 0.003f * static_cast<float>(t);  // 0.18 m/s at 60 Hz
    return patch(x, 0.0f, 0.006f, 3000.0f) + patch(x + 0.02f, 0.01f, 0.006f, 5000.0f) +
           patch(x + 0.02f, -0.01f, 0.006f, 4000.0f);
  };
  const auto first = renderer.render(frame(0));
  ASSERT_EQ(first.size(), 3u);
  for (int t = 1; t < 60; ++t) {
    const auto points = renderer.render(frame(t));
    ASSERT_EQ(points.size(), 3u) << t;
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(points[k].id, first[k].id) << t;
      EXPECT_NEAR(points[k].position.x() - first[k].position.x(), 0.003 * t, 1e-5);
      EXPECT_NEAR(points[k].position.y(), first[k].position.y(), 1e-5);
    }
  }
}

TEST(FocalPoints, KeepTheirIdsWhenAnotherComesAndGoes) {
  FocalPointRenderer renderer;
  const Samples thumb = patch(0.0f, 0.0f, 0.006f, 3000.0f);
  const Samples index = patch(0.03f, 0.0f, 0.006f, 3000.0f);
  const auto alone = renderer.render(thumb);
  ASSERT_EQ(alone.size(), 1u);
  const auto both = renderer.render(index + thumb);
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[0].id, alone[0].id);
  EXPECT_EQ(both[0].position, alone[0].position);
  const auto index_only = renderer.render(index);
  ASSERT_EQ(index_only.size(), 1u);
  EXPECT_EQ(index_only[0].id, both[1].id);
  const auto again = renderer.render(thumb + index);
  ASSERT_EQ(again.size(), 2u);
  EXPECT_EQ(again[0].id, both[1].id);
  EXPECT_GT(again[1].id, both[1].id) << "an id that died does not come back";
}

TEST(FocalPoints, ThatJumpGetANewId) {
  FocalPointRenderer renderer;
  const auto before = renderer.render(patch(0.0f, 0.0f, 0.006f, 3000.0f));
  const auto after = renderer.render(patch(0.1f, 0.0f, 0.006f, 3000.0f));
  ASSERT_EQ(after.size(), 1u);
  EXPECT_NE(after[0].id, before[0].id);
}

TEST(FocalPoints, OfAPalmStayUnderNoise) {
  // A symmetric palm has many nearly equal optima; the warm start must not wander between them.
  std::mt19937 random(9);
  std::uniform_real_distribution<float> noise(0.8f, 1.2f);
  FocalPointRenderer renderer;
  const Samples palm = patch(0.0f, 0.0f, 0.04f, 5000.0f);
  auto before = renderer.render(palm);
  for (int t = 0; t < 30; ++t) {
    Samples noisy = palm;
    for (auto& s : noisy) s.pressure *= noise(random);
    const auto points = renderer.render(noisy);
    ASSERT_EQ(points.size(), before.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      EXPECT_EQ(points[k].id, before[k].id) << t;
      EXPECT_LT((points[k].position - before[k].position).norm(), 0.003) << t;
    }
    before = points;
  }
}

TEST(FocalPoints, AreTheSameAfterReset) {
  FocalPointRenderer renderer;
  const auto first = renderer.render(patch(0.0f, 0.0f, 0.04f, 5000.0f));
  renderer.render(patch(0.01f, 0.0f, 0.03f, 5000.0f));
  renderer.reset();
  const auto again = renderer.render(patch(0.0f, 0.0f, 0.04f, 5000.0f));
  ASSERT_EQ(first.size(), again.size());
  for (std::size_t k = 0; k < first.size(); ++k) {
    EXPECT_EQ(first[k].id, again[k].id);
    EXPECT_EQ(first[k].position, again[k].position);
    EXPECT_EQ(first[k].pressure, again[k].pressure);
  }
}

TEST(FocalPoints, SurviveASmallerMaximumLive) {
  FocalPointRenderer renderer;
  const Samples palm = patch(0.0f, 0.0f, 0.04f, 5000.0f);
  EXPECT_EQ(renderer.render(palm).size(), 8u);
  FocalPointConfig config;
  config.max_points = 3;
  renderer.configure(config);
  EXPECT_EQ(renderer.render(palm).size(), 3u);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::focal_points_over_time_test
