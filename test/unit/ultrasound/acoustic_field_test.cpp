#include "ultrasound/acoustic_field.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "oracle.h"

namespace tactile_clay::ultrasound::acoustic_field_test {
namespace {

ArrayLayout singlePiston() {
  return {"one", 0.0, {{0, 0, 0}}, {{0, 0, 1}}};
}

Drive randomDrive(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> phase(0.0f, 6.28f);
  std::uniform_real_distribution<float> amplitude(0.0f, 1.0f);
  Drive drive;
  for (std::size_t i = 0; i < n; ++i) {
    drive.phase.push_back(phase(random));
    drive.amplitude.push_back(amplitude(random));
  }
  return drive;
}

TEST(AcousticField, OfOnePistonOnItsAxis) {
  Acoustics air;
  const Drive drive{{0.7f}, {0.5f}};
  for (const double z : {0.01, 0.1, 0.2, 0.5, 1.0}) {
    const std::complex<double> p = pressureAt(singlePiston(), air, drive, {0, 0, z});
    EXPECT_NEAR(std::abs(p), 0.5 * 3.4 / z * std::exp(-0.15 * z), 1e-9 / z);
    EXPECT_NEAR(std::abs(p / std::abs(p) - std::polar(1.0, air.wavenumber() * z + 0.7)), 0.0, 1e-6);
  }
}

TEST(AcousticField, AttenuatesByItsCoefficient) {
  // 1.3 dB/m over 1 m, in addition to the fall-off with distance.
  Acoustics air;
  const Drive drive{{0.0f}, {1.0f}};
  const double near = std::abs(pressureAt(singlePiston(), air, drive, {0, 0, 1.0}));
  const double far = std::abs(pressureAt(singlePiston(), air, drive, {0, 0, 2.0}));
  EXPECT_NEAR(20.0 * std::log10(near / (2.0 * far)), 1.303, 0.001);
}

TEST(AcousticField, OfOnePistonInTheFarFieldFollowsJ1) {
  const Acoustics air;
  const Drive drive{{0.0f}, {1.0f}};
  const double on_axis = std::abs(pressureAt(singlePiston(), air, drive, {0, 0, 0.5}));
  for (int degrees = 5; degrees < 90; degrees += 5) {
    const double angle = degrees * M_PI / 180.0;
    const Eigen::Vector3d point(0.5 * std::sin(angle), 0.0, 0.5 * std::cos(angle));
    const double x = air.wavenumber() * air.transducer_radius * std::sin(angle);
    EXPECT_NEAR(std::abs(pressureAt(singlePiston(), air, drive, point)) / on_axis,
                2.0 * std::cyl_bessel_j(1.0, x) / x, 1e-6)
        << degrees;
  }
}

TEST(AcousticField, EqualsAnIndependentSumOfSignals) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-0.15, 0.15);
  for (const char* name : {"usx", "autd3"}) {
    const ArrayLayout layout = arrayLayout(name);
    Acoustics air;
    air.temperature = 24.0;
    const Drive drive = randomDrive(layout.size(), 12);
    for (int trial = 0; trial < 50; ++trial) {
      const Eigen::Vector3d point(place(random), place(random), 0.25 + place(random));
      const double expected = heardAmplitude(layout, air, drive, point);
      EXPECT_NEAR(std::abs(pressureAt(layout, air, drive, point)), expected, 1e-3 + 1e-5 * expected);
    }
  }
}

TEST(AcousticField, IsLinearInTheDrive) {
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  const Eigen::Vector3d point(0.03, -0.02, 0.17);
  const Drive both = randomDrive(layout.size(), 13);
  Drive left = both;
  Drive right = both;
  for (std::size_t n = 0; n < layout.size(); ++n) (n % 2 == 0 ? left : right).amplitude[n] = 0.0f;
  const auto sum = pressureAt(layout, air, left, point) + pressureAt(layout, air, right, point);
  EXPECT_NEAR(std::abs(sum - pressureAt(layout, air, both, point)), 0.0, 1e-9);
  Drive half = both;
  for (float& a : half.amplitude) a *= 0.5f;
  EXPECT_NEAR(std::abs(pressureAt(layout, air, both, point) - 2.0 * pressureAt(layout, air, half, point)),
              0.0, 1e-9);
}

/// @param far whether a point is so far away that the air attenuates too much for the shorter of two formulas
void expectBatchEqualsTheDoublePrecisionSum(const ArrayLayout& layout, bool far) {
  std::mt19937 random(14);
  std::uniform_real_distribution<float> place(-0.2f, 0.2f);
  const Acoustics air;
  const Drive drive = randomDrive(layout.size(), 15);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 1001; ++i) points.emplace_back(place(random), place(random), 0.25f + place(random));
  if (far) points.emplace_back(1.0f, 2.0f, 3.0f);
  const auto fast = pressuresAt(layout, air, drive, points);
  ASSERT_EQ(fast.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d point = points[i].cast<double>();
    double maximum = 0.0;
    for (std::size_t n = 0; n < layout.size(); ++n) {
      maximum += drive.amplitude[n] * std::abs(transducerPressure(layout, air, n, point));
    }
    EXPECT_LE(std::abs(std::complex<double>(fast[i]) - pressureAt(layout, air, drive, point)),
              1e-4 * maximum);
  }
}

TEST(AcousticField, BatchEqualsTheDoublePrecisionSum) {
  const ArrayLayout flat = arrayLayout("usx");
  const Eigen::Isometry3d tilt(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()));
  for (const bool far : {false, true}) {
    expectBatchEqualsTheDoublePrecisionSum(flat, far);
    expectBatchEqualsTheDoublePrecisionSum(placed(flat, tilt), far);
    expectBatchEqualsTheDoublePrecisionSum(
        joined({flat, placed(flat, Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.2, 0.03)))}), far);
  }
}

// Patterns that take equal turns: mean squares add up, and radiation pressure is proportional to them.
TEST(AcousticField, MeanAmplitudeIsTheRootOfTheMeanSquare) {
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  const std::vector<Drive> drives = {randomDrive(layout.size(), 1), randomDrive(layout.size(), 2),
                                     randomDrive(layout.size(), 3)};
  const std::vector<Eigen::Vector3f> points = {{0, 0, 0.2f}, {0.03f, -0.02f, 0.15f}, {-0.05f, 0.01f, 0.1f}};
  const auto mean = meanAmplitudesAt(layout, air, drives, points);
  ASSERT_EQ(mean.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    double square = 0.0;
    for (const Drive& drive : drives)
      square += std::norm(pressureAt(layout, air, drive, points[i].cast<double>())) / 3.0;
    EXPECT_NEAR(static_cast<double>(mean[i]), std::sqrt(square),
                0.5);  // Pa, of some hundred: single precision
  }
  for (const float silent : meanAmplitudesAt(layout, air, {}, points)) EXPECT_EQ(silent, 0.0f);
}

TEST(AcousticField, BatchDoesNotDependOnThreads) {
  const ArrayLayout layout = arrayLayout("usx");
  const Drive drive = randomDrive(layout.size(), 16);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 3000; ++i) points.emplace_back(0.0001f * static_cast<float>(i), 0.01f, 0.2f);
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return pressuresAt(layout, {}, drive, points);
  };
  const auto one = run(1);
  EXPECT_EQ(one, run(2));
  EXPECT_EQ(one, run(4));
}

TEST(AcousticField, IsSilentBehindTheArrayAndAtNoPoint) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const ArrayLayout layout = arrayLayout("usx");
  const Drive drive = randomDrive(layout.size(), 17);
  const std::vector<Eigen::Vector3f> nowhere{{0, 0, -0.1f}, {nan, 0, 0.2f}, {0, 0, 1e30f}};
  for (const auto& p : pressuresAt(layout, {}, drive, nowhere)) EXPECT_EQ(p, std::complex<float>(0.0f));
  EXPECT_EQ(pressureAt(layout, {}, drive, {0, 0, -0.1}), 0.0);
  EXPECT_EQ(pressureAt(layout, {}, drive, {nan, 0, 0.2}), 0.0);
  EXPECT_TRUE(std::isfinite(std::abs(pressureAt(layout, {}, drive, layout.position[0]))));
  EXPECT_TRUE(std::isfinite(
      std::abs(pressureAt(layout, {}, drive, layout.position[0] + Eigen::Vector3d(0, 0, 1e-9)))));
}

TEST(AcousticField, RefusesADriveOfAnotherArray) {
  EXPECT_THROW(pressureAt(arrayLayout("autd3"), {}, randomDrive(256, 1), {0, 0, 0.2}), std::invalid_argument);
  EXPECT_THROW(pressuresAt(arrayLayout("autd3"), {}, randomDrive(256, 1), {}), std::invalid_argument);
}

TEST(AcousticField, OfSeveralArraysIsTheSumOfTheirs) {
  // Two arrays face each other; each field is that of the array alone, computed in its own frame.
  const Acoustics air;
  const ArrayLayout usx = arrayLayout("usx");
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(0.02, -0.01, 0.4);
  pose.linear() = (Eigen::AngleAxisd(M_PI - 0.2, Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()))
                      .toRotationMatrix();
  const ArrayLayout both = joined({usx, placed(usx, pose)});
  const Drive drive = randomDrive(512, 18);
  Drive lower{{drive.phase.begin(), drive.phase.begin() + 256},
              {drive.amplitude.begin(), drive.amplitude.begin() + 256}};
  Drive upper{{drive.phase.begin() + 256, drive.phase.end()},
              {drive.amplitude.begin() + 256, drive.amplitude.end()}};
  std::vector<Eigen::Vector3f> points;
  for (int i = -5; i <= 5; ++i) points.emplace_back(0.01f * static_cast<float>(i), 0.02f, 0.2f);
  const auto batch = pressuresAt(both, air, drive, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d x = points[i].cast<double>();
    const auto sum = pressureAt(usx, air, lower, x) + pressureAt(usx, air, upper, pose.inverse() * x);
    EXPECT_NEAR(std::abs(pressureAt(both, air, drive, x) - sum), 0.0, 1e-6);
    EXPECT_NEAR(std::abs(std::complex<double>(batch[i]) - sum), 0.0,
                2.0);  // 1e-4 of 256 x 2 x 0.5 x 3.4 / 0.2
  }
}

}  // namespace
}  // namespace tactile_clay::ultrasound::acoustic_field_test
