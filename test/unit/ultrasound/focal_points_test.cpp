#include "ultrasound/focal_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "ultrasound/phase_solver.h"

namespace tactile_clay::ultrasound {
namespace {

using contact::PressureSample;
using Samples = std::vector<PressureSample>;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float sample_area = 4e-6f;  // 2 mm grid

PressureSample sample(float x, float y, float pressure, float weight = 1.0f) {
  return {{x, y, 0.2f}, {0, 0, -1}, pressure, pressure * sample_area, sample_area, weight};
}

/// A round contact on a 2 mm grid, pressed hardest in the middle.
Samples patch(float cx, float cy, float radius, float pressure, float weight = 1.0f) {
  Samples samples;
  const int n = static_cast<int>(radius / 0.002f);
  for (int i = -n; i <= n; ++i) {
    for (int j = -n; j <= n; ++j) {
      const float d = 0.002f * std::hypot(static_cast<float>(i), static_cast<float>(j));
      if (d > radius) continue;
      const float share = 1.0f - 0.5f * (d / radius) * (d / radius);
      samples.push_back(sample(cx + 0.002f * static_cast<float>(i), cy + 0.002f * static_cast<float>(j),
                               pressure * share, weight));
    }
  }
  return samples;
}

Samples operator+(Samples a, const Samples& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

double gaussian(const PressureSample& s, const FocalPoint& point, double sigma) {
  return std::exp(-(s.position.cast<double>() - point.position).squaredNorm() / (2.0 * sigma * sigma));
}

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

TEST(FocalPoints, KeepOneGainWhereverTheyAreUpToTheLimitsOfTheArray) {
  // The radiation pressure of a point, intensity^2 R(x)^2 / M, is the same multiple of its clay pressure in
  // the middle and at the edge, alone and with others, as long as the array can give it.
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  FocalPointConfig config;
  config.full_scale_pressure = 60000.0;
  FocalPointRenderer renderer(config);
  renderer.setArray(ArrayReach(layout, air));
  const double gain = radiationPressure(air, focusPressure(layout, air, {0, 0, 0.2})) / 60000.0;
  for (const Samples& samples :
       {Samples{sample(0, 0, 3000)}, Samples{sample(0.09f, 0.05f, 3000)},
        Samples{sample(0, 0, 2000), sample(0.09f, 0, 4000), sample(-0.09f, 0, 1000)}}) {
    const auto points = renderer.render(samples);
    ASSERT_EQ(points.size(), samples.size());
    const RenderReport& report = renderer.report();
    EXPECT_NEAR(report.gain, gain, 1e-4 * gain);
    EXPECT_EQ(report.compressed_points, 0u);
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double amplitude = points[k].intensity * focusPressure(layout, air, points[k].position) /
                               std::sqrt(static_cast<double>(points.size()));
      EXPECT_NEAR(radiationPressure(air, amplitude), gain * points[k].pressure,
                  1e-3 * gain * points[k].pressure);
      EXPECT_NEAR(report.wanted[k], gain * points[k].pressure, 1e-3 * report.wanted[k]);
      EXPECT_NEAR(report.granted[k], report.wanted[k], 1e-9);
    }
  }
}

TEST(FocalPoints, ThatTheArrayCannotGiveAreReported) {
  FocalPointConfig config;
  config.full_scale_pressure = 60000.0;
  FocalPointRenderer renderer(config);
  renderer.setArray(ArrayReach(arrayLayout("usx"), Acoustics()));
  // One of them needs only a third of the array; four ask for more than the array has.
  const auto one = renderer.render({sample(0, 0, 20000)});
  EXPECT_EQ(renderer.report().compressed_points, 0u);
  EXPECT_NEAR(one[0].intensity, std::sqrt(1.0 / 3.0), 1e-3);
  const auto four = renderer.render(
      {sample(0, 0, 20000), sample(0.05f, 0, 20000), sample(-0.05f, 0, 20000), sample(0, 0.05f, 20000)});
  ASSERT_EQ(four.size(), 4u);
  EXPECT_EQ(renderer.report().saturated_points, 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_LT(four[k].intensity, 1.0);
    EXPECT_GT(four[k].intensity, 0.9);
    EXPECT_LT(renderer.report().granted[k], 0.8 * renderer.report().wanted[k]);
    EXPECT_GT(renderer.report().granted[k], 0.0);
  }
  const auto behind = renderer.render({{{0, 0, -0.2f}, {0, 0, 1}, 5000.0f, 0.02f, sample_area, 1.0f}});
  ASSERT_EQ(behind.size(), 1u);
  EXPECT_EQ(behind[0].intensity, 0.0);
  EXPECT_EQ(renderer.report().saturated_points, 1u);
  EXPECT_EQ(renderer.report().granted, std::vector<double>{0.0});
}

/// A focus is some six times as long as it is wide: contacts above each other are one point for the array,
/// contacts as far apart beside each other are two.
TEST(FocalPoints, ThatTheArrayCannotTellApartAreOne) {
  Samples above = patch(0.0f, 0.0f, 0.006f, 3000.0f);
  Samples beside = above;
  for (const PressureSample& s : patch(0.0f, 0.0f, 0.006f, 3000.0f)) {
    above.push_back(s);
    above.back().position.z() += 0.03f;
    beside.push_back(s);
    beside.back().position.x() += 0.03f;
  }
  FocalPointRenderer renderer;
  EXPECT_EQ(renderer.render(above).size(), 2u) << "no array";
  renderer.reset();
  const ArrayReach usx(arrayLayout("usx"), Acoustics());
  renderer.setArray(usx);
  const auto one = renderer.render(above);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(renderer.report().merged_points, 1u);
  EXPECT_LT(one[0].position.head<2>().norm(), 0.007);
  renderer.reset();
  EXPECT_EQ(renderer.render(beside).size(), 2u);
  EXPECT_EQ(renderer.report().merged_points, 0u);
  // All points of a hand that leans: far enough apart for the array, however they lie.
  Samples slope = patch(0.0f, 0.0f, 0.04f, 5000.0f);
  for (PressureSample& s : slope) s.position.z() += 1.5f * s.position.x();
  renderer.reset();
  const auto points = renderer.render(slope);
  ASSERT_GT(points.size(), 2u);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Eigen::Vector3d way = points[i].position - points[j].position;
      EXPECT_GE(way.norm(), renderer.config().min_separation);
      EXPECT_GE(separation(way, usx.beam(points[i].position), usx.beam(points[j].position),
                           Acoustics().wavenumber()),
                renderer.config().min_resolution);
    }
  }
}

/// Points that come from the frame before keep the distance, too, and become one when their contacts meet.
TEST(FocalPoints, BecomeOneForTheArrayWhenContactsMeet) {
  const ArrayReach usx(arrayLayout("usx"), Acoustics());
  FocalPointRenderer renderer;
  renderer.setArray(usx);
  std::size_t two = 0;
  std::vector<FocalPoint> points;
  for (float apart = 0.03f; apart > 0.0125f; apart -= 0.0005f) {
    points = renderer.render(patch(0.0f, 0.0f, 0.004f, 3000.0f) + patch(apart, 0.0f, 0.004f, 3000.0f));
    if (points.size() != 2) continue;
    ++two;
    EXPECT_GE(separation(points[1].position - points[0].position, usx.beam(points[0].position),
                         usx.beam(points[1].position), Acoustics().wavenumber()),
              renderer.config().min_resolution)
        << apart;
  }
  EXPECT_GT(two, 10u);
  EXPECT_EQ(points.size(), 1u) << "closer than a width of a focus, though not than min_separation";
}

/// The amplitude of a lone focus falls by half of the squared separation.
TEST(FocalPoints, SeparationIsTheParabolaOfAFocus) {
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  const ArrayReach reach(layout, air);
  const Eigen::Vector3d focus(0.03, -0.02, 0.18);
  FocalPoint point;
  point.position = focus;
  point.intensity = 1.0;
  const Drive drive = solvePhases(layout, air, {point}).drive;
  const FocusBeam beam = reach.beam(focus);
  for (const Eigen::Vector3d& way : {Eigen::Vector3d(1e-3, 0, 0), Eigen::Vector3d(0, 1e-3, 0)}) {
    const double there = 0.5 * (std::abs(pressureAt(layout, air, drive, focus + way)) +
                                std::abs(pressureAt(layout, air, drive, focus - way)));
    const double fall = 1.0 - there / std::abs(pressureAt(layout, air, drive, focus));
    EXPECT_NEAR(fall, 0.5 * std::pow(separation(way, beam, beam, air.wavenumber()), 2), 0.1 * fall);
  }
}

/// A square array has side lobes along its axes of 0.217 of a focus: the second extremum of sin(x)/x. The
/// floor is above it.
TEST(FocalPoints, WeakerThanSideLobesAreRaisedAboveThem) {
  FocalPointConfig config;
  config.full_scale_pressure = 60000.0;
  FocalPointRenderer renderer(config);
  renderer.setArray(ArrayReach(arrayLayout("usx"), Acoustics()));
  const Samples samples{sample(0.03f, 0, 20000), sample(-0.03f, 0, 300)};
  const auto raised = renderer.render(samples);
  ASSERT_EQ(raised.size(), 2u);
  const RenderReport report = renderer.report();
  const std::size_t weak = raised[0].pressure < raised[1].pressure ? 0 : 1;
  EXPECT_EQ(report.raised_points, 1u);
  EXPECT_NEAR(std::sqrt(report.granted[weak] / report.granted[1 - weak]), 0.25, 1e-9);
  EXPECT_NEAR(raised[weak].intensity / raised[1 - weak].intensity, 0.25, 1e-6) << "equally far, equal reach";
  EXPECT_GT(report.granted[weak], report.wanted[weak]);
  EXPECT_EQ(report.granted[1 - weak], std::min(report.wanted[1 - weak], report.granted[1 - weak]));
  config.side_lobe_floor = 0.0;
  renderer.configure(config);
  const auto plain = renderer.render(samples);
  EXPECT_EQ(renderer.report().raised_points, 0u);
  EXPECT_LT(plain[weak].intensity, 0.13 * plain[1 - weak].intensity);
}

/// A force that a person does not feel is raised to the person's threshold. With a gain of two, points are
/// twice as strong.
TEST(FocalPoints, KeepToThePersonsThresholdAndGain) {
  FocalPointConfig config;
  config.side_lobe_floor = 0.0;
  FocalPointRenderer renderer(config);
  renderer.setArray(ArrayReach(arrayLayout("usx"), Acoustics()));
  const Samples samples{sample(0.03f, 0, 20000), sample(-0.03f, 0, 300)};
  const auto forces = [&] {
    renderer.render(samples);
    std::vector<double> each;
    for (std::size_t k = 0; k < renderer.report().granted.size(); ++k)
      each.push_back(renderer.report().granted[k] * renderer.report().area[k]);
    std::sort(each.begin(), each.end());
    return each;
  };
  const auto others = forces();
  ASSERT_EQ(others.size(), 2u);
  config.felt_threshold = 0.5 * others[1];
  ASSERT_GT(config.felt_threshold, 2.0 * others[0]);
  renderer.configure(config);
  const auto felt = forces();
  EXPECT_NEAR(felt[0], config.felt_threshold, 1e-9);
  EXPECT_EQ(felt[1], others[1]);
  EXPECT_EQ(renderer.report().raised_points, 1u);
  config.felt_threshold = 0.0;
  config.felt_gain = 2.0;
  renderer.configure(config);
  EXPECT_NEAR(forces()[0], 2.0 * others[0], 1e-9);
  config.felt_gain = 0.0;
  EXPECT_THROW(renderer.configure(config), std::invalid_argument);
  config.felt_gain = 1.0;
  config.felt_threshold = 1.0;  // N: more than there is
  renderer.configure(config);
  for (const auto& point : renderer.render(samples)) EXPECT_NEAR(point.intensity, 1.0, 1e-9);
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
}  // namespace tactile_clay::ultrasound
