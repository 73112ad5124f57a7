#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "oracle.h"
#include "ultrasound/acoustic_field.h"

namespace tactile_clay::ultrasound::acoustic_field_focus_test {
namespace {

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

TEST(AcousticField, FocusHasTheKnownPressure) {
  // Linear model of a 16 x 16 array, pitch 10.3 mm, P_ref 3.4, in air without attenuation (with 0.15 Np/m
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
  // Reciprocity: a piston and a point may swap places if the angle between the piston's axis and the way to
  // the point stays the same.
  const ArrayLayout here{"here", 0.0, {{0.01, 0.02, 0.0}}, {{0, 0, 1}}};
  const ArrayLayout there{"there", 0.0, {{0.06, -0.03, 0.2}}, {{0, 0, -1}}};
  const auto forth = transducerPressure(here, air, 0, there.position[0]);
  const auto back = transducerPressure(there, air, 0, here.position[0]);
  EXPECT_NEAR(std::abs(forth - back), 0.0, 1e-12);
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

}  // namespace
}  // namespace tactile_clay::ultrasound::acoustic_field_focus_test
