#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "contacts.h"
#include "ultrasound/focal_points.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::ultrasound::focal_points_on_arrays_test {
namespace {

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

}  // namespace
}  // namespace tactile_clay::ultrasound::focal_points_on_arrays_test
