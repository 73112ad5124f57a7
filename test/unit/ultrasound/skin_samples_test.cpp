#include "ultrasound/skin_samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace tactile_clay::ultrasound::skin_samples_test {
namespace {

using contact::PressureSample;

/// A plane of samples 5 mm apart.
/// @param pressed how many rows
std::vector<PressureSample> plane(int side, int pressed, float weight) {
  std::vector<PressureSample> skin;
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      const float pressure = row < pressed ? 1000.0f : 0.0f;
      skin.push_back({{0.005f * static_cast<float>(column), 0.005f * static_cast<float>(row), 0.2f},
                      {0, 0, -1},
                      pressure,
                      pressure * 2.5e-5f,
                      2.5e-5f,
                      weight});
    }
  return skin;
}

double maxDistance(const std::vector<PressureSample>& skin, const std::vector<SkinSample>& samples) {
  double maximum = 0.0;
  for (const PressureSample& s : skin) {
    double closest = 1.0;
    for (const SkinSample& sample : samples)
      closest = std::min(closest, (sample.position - s.position.cast<double>()).norm());
    maximum = std::max(maximum, closest);
  }
  return maximum;
}

TEST(SkinSamples, AreTheSkinWhereThereIsNotMuchOfIt) {
  const auto skin = plane(10, 4, 0.3f);
  const auto samples = skinSamples(skin, 200);
  ASSERT_EQ(samples.size(), skin.size());
  EXPECT_LT(maxDistance(skin, samples), 1e-6);
  EXPECT_EQ(std::count_if(samples.begin(), samples.end(), [](const auto& s) { return s.pressure == 1000.0; }),
            40);
}

TEST(SkinSamples, AreSpreadOverTheSkinWhereThereIsMoreOfIt) {
  const auto skin = plane(30, 10, 1.0f);
  const auto samples = skinSamples(skin, 225);
  EXPECT_NEAR(static_cast<double>(samples.size()), 225.0, 2.0);
  EXPECT_LT(maxDistance(skin, samples), 0.015) << "a piece is of four samples";
  const auto pressed =
      std::count_if(samples.begin(), samples.end(), [](const auto& s) { return s.pressure > 0.0; });
  EXPECT_NEAR(static_cast<double>(pressed), 75.0, 2.0) << "a third of the skin";
}

TEST(SkinSamples, KeepTheMeanPressureOfWhatTheyStandFor) {
  auto skin = plane(20, 10, 1.0f);
  std::mt19937 random(4);
  double force = 0.0;
  for (auto& sample : skin)
    if (sample.pressure > 0.0f) {
      sample.pressure = 1000.0f + static_cast<float>(random() % 1000);
      force += sample.pressure / 200.0;
    }
  const auto samples = skinSamples(skin, 100);
  double mean = 0.0, count = 0.0;
  for (const SkinSample& sample : samples)
    if (sample.pressure > 0.0) {
      mean += sample.pressure;
      count += 1.0;
    }
  EXPECT_NEAR(mean / count, force, 0.02 * force);
}

TEST(SkinSamples, DoNotDependOnTheOrder) {
  auto skin = plane(20, 5, 1.0f);
  const auto before = skinSamples(skin, 80);
  std::shuffle(skin.begin(), skin.end(), std::mt19937(1));
  const auto after = skinSamples(skin, 80);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_EQ(before[k].position, after[k].position);
    EXPECT_EQ(before[k].pressure, after[k].pressure);
  }
}

TEST(SkinSamples, LookWhereTheSkinAtTheirPlaceLooks) {
  auto skin = plane(20, 5, 1.0f);
  for (auto& sample : skin)
    sample.normal = Eigen::Vector3f(sample.position.x(), sample.position.y(), -1).normalized();
  for (const std::size_t maximum : {80u, 400u})
    for (const SkinSample& sample : skinSamples(skin, maximum)) {
      const Eigen::Vector3d expected(sample.position.x(), sample.position.y(), -1.0);
      EXPECT_LT((sample.normal - expected.normalized()).norm(), 1e-6) << maximum;
    }
}

TEST(SkinSamples, TellATouchThatIsSmallerThanAPiece) {
  auto skin = plane(20, 0, 1.0f);
  skin[50].pressure = 500.0f;
  const auto samples = skinSamples(skin, 50);
  const auto touched =
      std::find_if(samples.begin(), samples.end(), [](const auto& s) { return s.pressure > 0.0; });
  ASSERT_NE(touched, samples.end());
  EXPECT_EQ(touched->position, skin[50].position.cast<double>());
  EXPECT_EQ(touched->pressure, 500.0);
  EXPECT_TRUE(skinSamples({}, 50).empty());
}

}  // namespace
}  // namespace tactile_clay::ultrasound::skin_samples_test
