#include "ultrasound/focal_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>

#include "contacts.h"

namespace tactile_clay::ultrasound::focal_points_test {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

TEST(FocalPoints, OfNoContactAreNone) {
  FocalPointRenderer renderer;
  EXPECT_TRUE(renderer.render({}).empty());
  EXPECT_EQ(renderer.report().ignored_samples, 0u);
}

TEST(FocalPoints, OfOneSampleIsThatSample) {
  FocalPointConfig config;
  config.full_scale_pressure = 10000.0;
  for (const auto fit : {IntensityFit::paper, IntensityFit::least_squares}) {
    config.fit = fit;
    FocalPointRenderer renderer(config);
    const auto points = renderer.render({sample(0.01f, 0.02f, 2500.0f)});
    ASSERT_EQ(points.size(), 1u);
    EXPECT_NEAR((points[0].position - Eigen::Vector3d(0.01, 0.02, 0.2)).norm(), 0.0, 1e-8);
    EXPECT_NEAR(points[0].pressure, 2500.0, 1e-9);
    EXPECT_NEAR(points[0].intensity, 0.5, 1e-12);  // sqrt(2500 / 10000)
  }
}

TEST(FocalPoints, SmallContactGetsOnePointAtItsWeightedMean) {
  FocalPointRenderer renderer;
  const auto points = renderer.render(patch(0.03f, -0.02f, 0.006f, 3000.0f));
  ASSERT_EQ(points.size(), 1u);
  EXPECT_NEAR((points[0].position - Eigen::Vector3d(0.03, -0.02, 0.2)).norm(), 0.0, 1e-7);
}

TEST(FocalPoints, FiveFingersGetOnePointEach) {
  FocalPointRenderer renderer;
  Samples samples;
  for (int i = 0; i < 5; ++i) samples = samples + patch(0.02f * static_cast<float>(i), 0.0f, 0.006f, 3000.0f);
  const auto points = renderer.render(samples);
  ASSERT_EQ(points.size(), 5u);
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector3d finger(0.02 * i, 0.0, 0.2);
    EXPECT_TRUE(std::any_of(points.begin(), points.end(),
                            [&](const FocalPoint& p) { return (p.position - finger).norm() < 1e-6; }));
  }
}

TEST(FocalPoints, RespectMaxPointsAndSeparation) {
  const Samples palm = patch(0.0f, 0.0f, 0.045f, 5000.0f);
  std::size_t before = 0;
  for (std::size_t max = 1; max <= 16; ++max) {
    FocalPointConfig config;
    config.max_points = max;
    FocalPointRenderer renderer(config);
    const auto points = renderer.render(palm);
    EXPECT_LE(points.size(), max);
    EXPECT_GE(points.size(), before);  // a palm has room for more
    before = points.size();
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        EXPECT_GE((points[i].position - points[j].position).norm(), config.min_separation);
      }
    }
  }
  EXPECT_EQ(before, 16u);
}

TEST(FocalPoints, DoNotDependOnHowFinelyTheSkinIsSampled) {
  // A sample split into two of half its area is the same contact. Fingers, because a palm has many equal
  // optima.
  const Samples samples = patch(0.001f, 0.0f, 0.008f, 4000.0f) + patch(0.04f, 0.0f, 0.006f, 6000.0f);
  Samples split;
  for (PressureSample s : samples) {
    s.area /= 2.0f;
    s.force /= 2.0f;
    split.push_back(s);
    if (s.position.x() > 0.002f) {
      split.push_back(s);
    } else {
      split.back().area *= 2.0f;  // not split
    }
  }
  const auto whole = FocalPointRenderer().render(samples);
  const auto halves = FocalPointRenderer().render(split);
  ASSERT_EQ(whole.size(), halves.size());
  for (std::size_t k = 0; k < whole.size(); ++k) {
    EXPECT_LT((whole[k].position - halves[k].position).norm(), 1e-9);
    EXPECT_NEAR(whole[k].pressure, halves[k].pressure, 1e-6);
  }
}

TEST(FocalPoints, WeightsPullPointsTowardsSensitiveSkin) {
  // One contact from pad to palm: with weights the one point moves to the pad, and the error there falls
  // (Fig. 4).
  Samples samples;
  for (int i = 0; i < 40; ++i) {
    samples.push_back(sample(0.001f * static_cast<float>(i), 0.0f, 3000.0f, i < 12 ? 1.0f : 0.25f));
  }
  FocalPointConfig config;
  config.max_points = 1;
  const auto weighted = FocalPointRenderer(config).render(samples);
  config.perceptual_weights = false;
  const auto plain = FocalPointRenderer(config).render(samples);
  EXPECT_NEAR(plain[0].position.x(), 0.0195, 1e-6);
  EXPECT_LT(weighted[0].position.x(), 0.015);
  EXPECT_LT(reconstructionError(samples, weighted, config.sigma, true),
            reconstructionError(samples, plain, config.sigma, true));
}

TEST(FocalPoints, OfContactsBelowTheThresholdsAreNone) {
  FocalPointConfig config;
  config.minimum_pressure = 100.0;
  config.minimum_force = 0.001;
  FocalPointRenderer renderer(config);
  EXPECT_TRUE(renderer.render({sample(0, 0, 99.0f)}).empty());
  EXPECT_TRUE(renderer.render({sample(0, 0, 200.0f)}).empty());   // 0.8 mN
  EXPECT_EQ(renderer.render({sample(0, 0, 300.0f)}).size(), 1u);  // 1.2 mN
}

TEST(FocalPoints, IgnoreAndCountBrokenSamples) {
  FocalPointRenderer renderer;
  Samples samples = patch(0.0f, 0.0f, 0.006f, 3000.0f);
  const auto clean = FocalPointRenderer().render(samples);
  samples.push_back(sample(nan, 0, 1e6f));
  samples.push_back(sample(0, 0, nan));
  samples.push_back(sample(0.1f, 0, std::numeric_limits<float>::infinity()));
  samples.push_back(sample(0.1f, 0, 1000.0f, nan));
  samples.push_back(sample(0.1f, 0, 1000.0f));
  samples.back().area = 0.0f;
  const auto points = renderer.render(samples);
  EXPECT_EQ(renderer.report().ignored_samples, 5u);
  ASSERT_EQ(points.size(), clean.size());
  EXPECT_EQ(points[0].position, clean[0].position);
  EXPECT_EQ(points[0].pressure, clean[0].pressure);
  EXPECT_FALSE(std::isnan(reconstructionError(samples, points, 0.0086)));
}

TEST(FocalPoints, DoNotDependOnTheOrderOfSamples) {
  Samples samples = patch(0.0f, 0.0f, 0.03f, 4000.0f) + patch(0.1f, 0.0f, 0.008f, 6000.0f);
  const auto reference = FocalPointRenderer().render(samples);
  std::mt19937 random(8);
  for (int trial = 0; trial < 10; ++trial) {
    std::shuffle(samples.begin(), samples.end(), random);
    const auto points = FocalPointRenderer().render(samples);
    ASSERT_EQ(points.size(), reference.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      EXPECT_EQ(points[k].id, reference[k].id);
      EXPECT_EQ(points[k].position, reference[k].position);  // bit by bit
      EXPECT_EQ(points[k].intensity, reference[k].intensity);
    }
  }
}

TEST(FocalPoints, LieOnTheSkinWhereTheMeanDoesNot) {
  // One point for two hands: in the air between them it would touch no hand.
  FocalPointConfig config;
  config.max_points = 1;
  const auto points =
      FocalPointRenderer(config).render(patch(-0.5f, 0, 0.006f, 3000.0f) + patch(0.5f, 0, 0.006f, 3000.0f));
  ASSERT_EQ(points.size(), 1u);
  EXPECT_NEAR(std::abs(points[0].position.x()), 0.5, 0.007);
  EXPECT_TRUE(std::isfinite(points[0].pressure));
  EXPECT_LT(points[0].pressure, 6000.0);
}

TEST(FocalPoints, RefuseBadSettingsByName) {
  const auto message = [](auto change) {
    FocalPointConfig config;
    change(config);
    try {
      FocalPointRenderer renderer(config);
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(message([](auto& c) { c.max_points = 0; }).find("max_points"), std::string::npos);
  EXPECT_NE(message([](auto& c) { c.min_resolution = -1.0; }).find("min_resolution"), std::string::npos);
  EXPECT_NE(message([](auto& c) { c.side_lobe_floor = 1.5; }).find("side_lobe_floor"), std::string::npos);
  EXPECT_NE(message([](auto& c) { c.sigma = 0.0; }).find("sigma"), std::string::npos);
  EXPECT_NE(message([](auto& c) { c.min_separation = -1.0; }).find("min_separation"), std::string::npos);
  EXPECT_EQ(message([](auto& c) { c.full_scale_pressure = std::nan(""); }),
            "focal points: full_scale_pressure: expected a finite number above 0, got nan");
  EXPECT_NE(message([](auto& c) { c.minimum_force = -1.0; }).find("minimum_force"), std::string::npos);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::focal_points_test
