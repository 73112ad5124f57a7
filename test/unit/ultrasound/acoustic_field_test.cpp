#include "ultrasound/acoustic_field.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "oracle.h"

namespace tactile_clay::ultrasound {
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

/// Phases that make all waves arrive together, written from the geometry alone: sound from a near transducer
/// must start later, and a phase of cos(omega t - phi) is a delay.
Drive focusedAt(const ArrayLayout& layout, const Acoustics& air, const Eigen::Vector3d& focus) {
  Drive drive;
  const double wavelength = 331.3 * std::sqrt(1.0 + air.temperature / 273.15) / air.frequency;
  for (const auto& x : layout.position) {
    drive.phase.push_back(static_cast<float>(std::fmod(-(focus - x).norm() / wavelength, 1.0) * 2.0 * M_PI));
    drive.amplitude.push_back(1.0f);
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
  // 1.3 dB/m over 1 m, beside the fall-off with distance.
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

TEST(AcousticField, FocusHasTheKnownPressure) {
  // Linear model of a 16 x 16 array, pitch 10.3 mm, P_ref 3.4, in air that takes nothing (with 0.15 Np/m
  // peaks are 1.7 % to 4.5 % lower): peak within 2 %, -6 dB width within 10 %.
  struct Row {
    double height, peak, width;
  };
  const ArrayLayout layout = arrayLayout("usx");
  Acoustics air;
  air.attenuation = 0.0;
  for (const Row& row : {Row{0.10, 5013, 8.8e-3}, Row{0.15, 4305, 11.2e-3}, Row{0.20, 3623, 14.0e-3},
                         Row{0.30, 2659, 20.0e-3}}) {
    const Drive drive = focusedAt(layout, air, {0, 0, row.height});
    const double peak = std::abs(pressureAt(layout, air, drive, {0, 0, row.height}));
    EXPECT_NEAR(peak, row.peak, 0.02 * row.peak) << row.height;
    double half_width = 0.0;
    while (std::abs(pressureAt(layout, air, drive, {half_width, 0, row.height})) > 0.5 * peak)
      half_width += 1e-5;
    EXPECT_NEAR(2.0 * half_width, row.width, 0.1 * row.width) << row.height;
  }
}

TEST(AcousticField, OfOneFocusPeaksAtTheFocus) {
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  for (const Eigen::Vector3d& focus : {Eigen::Vector3d(0, 0, 0.2), Eigen::Vector3d(0.04, -0.03, 0.15)}) {
    const Drive drive = focusedAt(layout, air, focus);
    Eigen::Vector3d best = focus;
    double peak = 0.0;
    for (int i = -60; i <= 60; ++i) {
      for (int j = -60; j <= 60; ++j) {
        const Eigen::Vector3d point = focus + Eigen::Vector3d(0.001 * i, 0.001 * j, 0.0);
        const double p = std::abs(pressureAt(layout, air, drive, point));
        if (p > peak) {
          peak = p;
          best = point;
        }
      }
    }
    EXPECT_LT((best - focus).norm(), air.wavelength() / 4.0);
  }
}

TEST(AcousticField, ConjugatePhasesDoNotFocus) {
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  const Eigen::Vector3d focus(0.02, 0.01, 0.2);
  Drive drive = focusedAt(layout, air, focus);
  const double right = heardAmplitude(layout, air, drive, focus);
  for (float& phase : drive.phase) phase = -phase;
  EXPECT_LT(std::abs(pressureAt(layout, air, drive, focus)), 0.1 * right);
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

TEST(AcousticField, HasTheSymmetryOfTheArray) {
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  const Drive drive = focusedAt(layout, air, {0, 0, 0.2});
  const double p = std::abs(pressureAt(layout, air, drive, {0.02, 0.03, 0.18}));
  for (const Eigen::Vector3d& mirrored :
       {Eigen::Vector3d(-0.02, 0.03, 0.18), Eigen::Vector3d(0.02, -0.03, 0.18),
        Eigen::Vector3d(0.03, 0.02, 0.18), Eigen::Vector3d(-0.03, -0.02, 0.18)}) {
    EXPECT_NEAR(std::abs(pressureAt(layout, air, drive, mirrored)), p, 1e-3);
  }
  // Reciprocity: a piston and a point may swap places, when the piston's axis still sees the other at its
  // angle.
  const ArrayLayout here{"here", 0.0, {{0.01, 0.02, 0.0}}, {{0, 0, 1}}};
  const ArrayLayout there{"there", 0.0, {{0.06, -0.03, 0.2}}, {{0, 0, -1}}};
  const auto forth = transducerPressure(here, air, 0, there.position[0]);
  const auto back = transducerPressure(there, air, 0, here.position[0]);
  EXPECT_NEAR(std::abs(forth - back), 0.0, 1e-12);
}

/// @param far with a point so far away that the air takes more than the shorter of two formulas holds for
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

// Patterns that take equal turns: mean squares add up, which radiation pressure goes with.
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

TEST(AcousticField, HeadSplIsTheLevelOfTheField) {
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  Drive drive = focusedAt(layout, air, {0, 0, 0.2});
  const Eigen::Vector3d head(0.0, -0.3, 0.4);
  const double rms = heardAmplitude(layout, air, drive, head) / std::sqrt(2.0);
  EXPECT_NEAR(headSpl(layout, air, drive, head), 20.0 * std::log10(rms / 20e-6), 0.01);
  EXPECT_GT(headSpl(layout, air, drive, head), 90.0);  // published: 96 to 137 dB at 0.5 m
  EXPECT_LT(headSpl(layout, air, drive, head), 140.0);
  drive.amplitude.assign(256, 0.0f);
  EXPECT_EQ(headSpl(layout, air, drive, head), 0.0);
}

TEST(AcousticField, OfSeveralArraysIsTheSumOfTheirs) {
  // Two arrays face each other; each field is that of the array alone, seen in its own frame.
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
}  // namespace tactile_clay::ultrasound
