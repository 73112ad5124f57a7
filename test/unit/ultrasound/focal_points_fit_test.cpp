#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "contacts.h"
#include "ultrasound/focal_points.h"

namespace tactile_clay::ultrasound::focal_points_fit_test {
namespace {

/// The objective printed in Eq. 9, of one point with all samples.
double leastSquares(const Samples& samples, const FocalPoint& point, double pressure, double sigma) {
  double sum = 0.0;
  for (const auto& s : samples) {
    const double error = pressure * gaussian(s, point, sigma) - s.pressure;
    sum += s.area * error * error;
  }
  return sum;
}

template <typename F>
double goldenSection(F f, double low, double high) {
  const double ratio = (std::sqrt(5.0) - 1.0) / 2.0;
  for (int i = 0; i < 200; ++i) {
    const double a = high - ratio * (high - low);
    const double b = low + ratio * (high - low);
    if (f(a) < f(b)) {
      high = b;
    } else {
      low = a;
    }
  }
  return 0.5 * (low + high);
}

TEST(FocalPoints, MorePointsReconstructTheFieldBetter) {
  const Samples palm = patch(0.0f, 0.0f, 0.045f, 5000.0f);
  double before = 1.0;
  for (const std::size_t max : {1u, 2u, 4u, 8u, 16u}) {
    FocalPointConfig config;
    config.max_points = max;
    FocalPointRenderer renderer(config);
    const double error = reconstructionError(palm, renderer.render(palm), config.sigma);
    EXPECT_LT(error, before) << max;
    before = error;
  }
  EXPECT_LT(before, 0.6);
}

TEST(FocalPoints, LeastSquaresFitMinimisesEquation9) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(-0.008f, 0.008f);
  std::uniform_real_distribution<float> strength(500.0f, 8000.0f);
  FocalPointConfig config;
  config.max_points = 1;
  for (int trial = 0; trial < 20; ++trial) {
    Samples samples;
    for (int i = 0; i < 30; ++i) samples.push_back(sample(place(random), place(random), strength(random)));
    config.fit = IntensityFit::least_squares;
    const auto fitted = FocalPointRenderer(config).render(samples);
    config.fit = IntensityFit::paper;
    const auto printed = FocalPointRenderer(config).render(samples);
    ASSERT_EQ(fitted.size(), 1u);
    ASSERT_EQ(printed.size(), 1u);

    const auto objective = [&](double p) { return leastSquares(samples, fitted[0], p, config.sigma); };
    const double best = goldenSection(objective, 0.0, 1e5);
    EXPECT_NEAR(fitted[0].pressure, best, 1e-5 * best);
    EXPECT_LT(printed[0].pressure, 0.95 * best) << "the form printed in Eq. 9 is not the minimiser";
    EXPECT_GT(objective(printed[0].pressure), objective(fitted[0].pressure));
    EXPECT_LT(reconstructionError(samples, fitted, config.sigma),
              reconstructionError(samples, printed, config.sigma));
  }
}

TEST(FocalPoints, PaperFitIsTheGaussianMeanOfEquation9) {
  FocalPointConfig config;
  config.max_points = 1;
  config.fit = IntensityFit::paper;
  const Samples samples = patch(0.0f, 0.0f, 0.01f, 4000.0f);
  const auto points = FocalPointRenderer(config).render(samples);
  ASSERT_EQ(points.size(), 1u);
  double target = 0.0;
  double model = 0.0;
  for (const auto& s : samples) {
    const double g = gaussian(s, points[0], config.sigma);
    target += s.pressure * g;
    model += g;
  }
  EXPECT_NEAR(points[0].pressure, target / model, 1e-6);
}

TEST(FocalPoints, IntensityIsTheRootOfThePressureAndClips) {
  FocalPointConfig config;
  config.full_scale_pressure = 4000.0;
  config.compression_knee = 1.0;
  FocalPointRenderer renderer(config);
  const auto points =
      renderer.render({sample(0, 0, 1000.0f), sample(0.1f, 0, 4000.0f), sample(0.2f, 0, 9000.0f)});
  ASSERT_EQ(points.size(), 3u);
  std::vector<double> intensity;
  for (const auto& p : points) intensity.push_back(p.intensity);
  std::sort(intensity.begin(), intensity.end());
  EXPECT_NEAR(intensity[0], 0.5, 1e-12);
  EXPECT_NEAR(intensity[1], 1.0, 1e-12);
  EXPECT_EQ(intensity[2], 1.0);
  EXPECT_EQ(renderer.report().saturated_points, 1u);
}

TEST(FocalPoints, CompressionIsSmoothAndNeverReachesAll) {
  for (const double knee : {0.0, 0.3, 0.5, 0.9}) {
    for (double share = 0.0; share <= knee; share += 0.1) EXPECT_EQ(compress(share, knee), share);
    double before = 0.0;
    for (double share = 0.01; share < 10.0; share += 0.01) {
      const double given = compress(share, knee);
      EXPECT_GE(given, before);
      EXPECT_LE(given, std::min(share, 1.0) + 1e-15);
      EXPECT_LE(given - before, 0.01 + 1e-12);  // slope at most 1
      before = given;
    }
    const double h = 1e-6;
    EXPECT_NEAR((compress(knee + h, knee) - knee) / h, 1.0, 1e-4) << "continuous slope at the knee";
  }
  EXPECT_EQ(compress(7.0, 1.0), 1.0);
}

TEST(FocalPoints, ReportTheErrorOfTheField) {
  FocalPointRenderer renderer;
  Samples samples = patch(0.0f, 0.0f, 0.02f, 3000.0f, 0.3f) + patch(0.08f, 0.0f, 0.006f, 3000.0f, 1.0f);
  const auto points = renderer.render(samples);
  // Written out: each sample sees its closest point.
  double error = 0.0, total = 0.0, weighted = 0.0, weighted_total = 0.0;
  for (const auto& s : samples) {
    const FocalPoint* closest = &points[0];
    for (const auto& p : points) {
      if ((p.position - s.position.cast<double>()).norm() <
          (closest->position - s.position.cast<double>()).norm()) {
        closest = &p;
      }
    }
    const double e = closest->pressure * gaussian(s, *closest, renderer.config().sigma) - s.pressure;
    error += e * e;
    total += static_cast<double>(s.pressure) * s.pressure;
    weighted += s.weight * e * e;
    weighted_total += s.weight * static_cast<double>(s.pressure) * s.pressure;
  }
  EXPECT_NEAR(renderer.report().error, std::sqrt(error / total), 1e-6);
  EXPECT_NEAR(renderer.report().weighted_error, std::sqrt(weighted / weighted_total), 1e-6);
  EXPECT_GT(renderer.report().error, 0.01);
  renderer.render({});
  EXPECT_EQ(renderer.report().error, 0.0);
}

TEST(FocalPoints, ReconstructionErrorOfAPerfectFieldIsZero) {
  FocalPoint point;
  point.position = {0, 0, 0.2};
  point.pressure = 1000.0;
  Samples samples;
  for (int i = 0; i < 10; ++i) {
    PressureSample s = sample(0.002f * static_cast<float>(i), 0, 1.0f);
    s.pressure = static_cast<float>(1000.0 * gaussian(s, point, 0.0086));
    samples.push_back(s);
  }
  EXPECT_NEAR(reconstructionError(samples, {point}, 0.0086), 0.0, 1e-6);
  EXPECT_DOUBLE_EQ(reconstructionError(samples, {}, 0.0086), 1.0);
  EXPECT_DOUBLE_EQ(reconstructionError({}, {point}, 0.0086), 0.0);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::focal_points_fit_test
