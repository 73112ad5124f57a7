#include "ultrasound/modulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

#include "oracle.h"
#include "ultrasound/focal_points.h"

namespace tactile_clay::ultrasound::modulation_test {
namespace {

FocalPoint point(double x, double y, double intensity = 1.0) {
  FocalPoint p;
  p.position = {x, y, 0.2};
  p.intensity = intensity;
  return p;
}

double length(const std::vector<Eigen::Vector3d>& points, const std::vector<std::size_t>& order) {
  double sum = 0.0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    sum += (points[order[i]] - points[order[(i + 1) % order.size()]]).norm();
  }
  return sum;
}

TEST(Modulation, IsNamed) {
  EXPECT_EQ(modulation("am"), Modulation::amplitude);
  EXPECT_EQ(modulation("lateral"), Modulation::lateral);
  EXPECT_EQ(modulation("stm"), Modulation::spatiotemporal);
  EXPECT_EQ(modulation("field"), Modulation::field);
  EXPECT_EQ(modulation("circle"), Modulation::circle);
  EXPECT_EQ(modulation("field_circle"), Modulation::field_circle);
  const auto names = modulationNames();
  for (std::size_t k = 0; k < names.size(); ++k)
    EXPECT_EQ(nameOf(static_cast<Modulation>(k)), names[k]) << "numbered as in FocalPointArray";
  EXPECT_THROW(modulation("AM"), std::invalid_argument);
}

TEST(Modulation, TourVisitsAllAndIsNearlyTheShortest) {
  // Against all (n - 1)! / 2 tours of seven points: the shortest in most cases, within 10 % in all.
  std::mt19937 random(41);
  std::uniform_real_distribution<double> place(-0.05, 0.05);
  int shortest = 0;
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 7; ++i) points.emplace_back(place(random), place(random), 0.2);
    const auto found = tour(points);
    ASSERT_EQ(found.size(), 7u);
    EXPECT_EQ(found[0], 0u);
    std::vector<std::size_t> all = found;
    std::sort(all.begin(), all.end());
    for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(all[i], i);
    double best = length(points, all);
    while (std::next_permutation(all.begin() + 1, all.end())) best = std::min(best, length(points, all));
    EXPECT_LE(length(points, found), 1.1 * best);
    shortest += length(points, found) <= best * (1.0 + 1e-9) ? 1 : 0;
  }
  EXPECT_GE(shortest, 40);
  EXPECT_TRUE(tour({}).empty());
  EXPECT_EQ(tour({{0, 0, 0}}).size(), 1u);
  EXPECT_EQ(tour(std::vector<Eigen::Vector3d>(4, Eigen::Vector3d(1, 2, 3))).size(), 4u);
}

TEST(Modulation, EnvelopeOfAmSwingsThePressureAsACosine) {
  for (double t = 0.0; t < 2.0; t += 0.01) {
    EXPECT_NEAR(std::pow(envelope(Modulation::amplitude, t), 2), 0.5 * (1.0 - std::cos(2.0 * M_PI * t)),
                1e-12);
    EXPECT_EQ(envelope(Modulation::lateral, t), 1.0);
    EXPECT_EQ(envelope(Modulation::spatiotemporal, t), 1.0);
  }
}

TEST(Modulation, LateralStepsAreUnderAMillimetreAndReturn) {
  const auto instants = period({point(0.01, 0.02)}, Modulation::lateral);
  double farthest = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < instants.size(); ++i) {
    const Eigen::Vector3d here = (*instants[i].points)[0].position;
    const Eigen::Vector3d next = (*instants[(i + 1) % instants.size()].points)[0].position;
    EXPECT_LE((next - here).norm(), 0.001 + 1e-12);
    EXPECT_EQ(instants[i].amplitude, 1.0);
    farthest = std::max(farthest, (here - Eigen::Vector3d(0.01, 0.02, 0.2)).norm());
    mean += here / static_cast<double>(instants.size());
  }
  EXPECT_NEAR(farthest, 0.5 * lateral_stroke, 1e-12);
  EXPECT_NEAR((mean - Eigen::Vector3d(0.01, 0.02, 0.2)).norm(), 0.0, 1e-12);
}

// Morisaki et al. 2024, doi 10.1109/TOH.2023.3338230: foci on a circle of 3 mm radius. Steps of points are
// under 1 mm, as for lateral modulation (Morisaki et al. 2022, doi 10.1109/TOH.2021.3125843).
TEST(Modulation, CirclesAreThosePublished) {
  const Eigen::Vector3d centre(0.01, 0.02, 0.2);
  for (const Modulation mode : {Modulation::circle, Modulation::field_circle}) {
    const auto instants = period({point(0.01, 0.02), point(0.05, 0.0)}, mode);
    ASSERT_EQ(instants.size(), mode == Modulation::circle ? circle_steps : field_circle_steps);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < instants.size(); ++i) {
      const Eigen::Vector3d here = (*instants[i].points)[0].position;
      const Eigen::Vector3d next = (*instants[(i + 1) % instants.size()].points)[0].position;
      EXPECT_NEAR((here - centre).norm(), 0.003, 1e-12);
      EXPECT_EQ(here.z(), 0.2);
      EXPECT_NEAR(((*instants[i].points)[1].position - here - Eigen::Vector3d(0.04, -0.02, 0)).norm(), 0.0,
                  1e-12)
          << "all go round as one";
      EXPECT_LE((next - here).norm(), mode == Modulation::circle ? 0.001 : 0.0024);
      EXPECT_EQ(instants[i].amplitude, 1.0);
      mean += here / static_cast<double>(instants.size());
    }
    EXPECT_NEAR((mean - centre).norm(), 0.0, 1e-12);
    EXPECT_EQ(parts(instants).size(), instants.size());
  }
}

TEST(Modulation, PartsAreTheDifferentInstantsOfAPeriod) {
  const std::vector<FocalPoint> points = {point(0.0, 0.0), point(0.03, 0.0, 0.5)};
  // AM: one part, all the time, with half its power: the mean of (1 - cos) / 2.
  const auto am = parts(period(points, Modulation::amplitude));
  ASSERT_EQ(am.size(), 1u);
  EXPECT_NEAR(am[0].time, 1.0, 1e-12);
  EXPECT_NEAR(am[0].power, 0.5, 1e-12);
  EXPECT_EQ(am[0].instants.size(), period_steps);
  // To and fro: the turning points once, all places between them twice.
  const auto lateral = parts(period(points, Modulation::lateral));
  ASSERT_EQ(lateral.size(), period_steps / 2 + 1);
  double time = 0.0;
  for (const Part& part : lateral) {
    const double x = part.points[0].position.x();
    EXPECT_NEAR(part.points[1].position.x() - x, 0.03, 1e-12);
    EXPECT_EQ(part.instants.size(), std::abs(std::abs(x) - 0.003) < 1e-9 ? 1u : 2u);
    EXPECT_NEAR(part.power, part.time, 1e-12);
    time += part.time;
  }
  EXPECT_NEAR(time, 1.0, 1e-12);
  const auto stm = parts(period(points, Modulation::spatiotemporal));
  ASSERT_EQ(stm.size(), 2u);
  EXPECT_EQ(stm[1].points.size(), 1u);
  EXPECT_NEAR(stm[1].time, 0.5, 1e-12);
  EXPECT_TRUE(parts({}).empty());
}

TEST(Modulation, PathCoversTheContactWithSpacing) {
  std::vector<Eigen::Vector3d> position;
  std::vector<double> pressure;
  for (int i = -15; i <= 15; ++i) {
    for (int j = -15; j <= 15; ++j) {
      if (i * i + j * j > 225) continue;
      position.emplace_back(0.002 * i, 0.002 * j, 0.2);
      pressure.push_back(3000.0 + 100.0 * i);
    }
  }
  const auto path = samplePath(position, pressure, pressure, 0.01, 64);
  for (std::size_t a = 0; a < path.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) EXPECT_GE((path[a].position - path[b].position).norm(), 0.01);
    EXPECT_NEAR(path[a].pressure, 3000.0 + 100.0 * path[a].position.x() / 0.002, 250.0);
  }
  for (const auto& x : position) {
    EXPECT_TRUE(std::any_of(path.begin(), path.end(),
                            [&x](const PathPoint& p) { return (p.position - x).norm() < 0.01 + 1e-9; }));
  }
  EXPECT_EQ(samplePath(position, pressure, pressure, 0.01, 5).size(), 5u);
  EXPECT_TRUE(samplePath({}, {}, {}, 0.01, 5).empty());
  EXPECT_THROW(samplePath(position, pressure, {}, 0.01, 5), std::invalid_argument);
}

TEST(Modulation, FrequencyOfATourIsThatOfItsSpeed) {
  std::vector<FocalPoint> square = {point(0, 0), point(0.05, 0), point(0.05, 0.05), point(0, 0.05)};
  EXPECT_NEAR(spatiotemporalFrequency(square, 6.0), 30.0, 1e-9);
  EXPECT_EQ(spatiotemporalFrequency({point(0, 0)}), 200.0);
}

TEST(Modulation, TactilePressureIsTheTimeAverageOfTheField) {
  // By the independent field, instant by instant.
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  const std::vector<FocalPoint> points = {point(-0.02, 0.0), point(0.02, 0.01, 0.6)};
  const std::vector<Eigen::Vector3f> at = {{-0.02f, 0, 0.2f}, {0.02f, 0.01f, 0.2f}, {0.0f, 0.03f, 0.2f}};
  for (const Modulation mode :
       {Modulation::amplitude, Modulation::lateral, Modulation::spatiotemporal, Modulation::circle}) {
    const auto instants = period(points, mode);
    const auto average = tactilePressure(layout, air, instants, {}, at);
    ASSERT_EQ(average.size(), at.size());
    for (std::size_t i = 0; i < at.size(); ++i) {
      double expected = 0.0;
      for (const Instant& instant : instants) {
        const Drive drive = solvePhases(layout, air, *instant.points).drive;
        const double p = instant.amplitude * heardAmplitude(layout, air, drive, at[i].cast<double>());
        expected += 0.5 * p * p * 2.0 / (air.airDensity() * std::pow(air.soundSpeed(), 2)) /
                    static_cast<double>(instants.size());
      }
      EXPECT_NEAR(average[i], expected, 1e-3 * expected + 1e-3);
    }
  }
  // A focus alone, modulated in amplitude: half of its radiation pressure.
  const auto alone =
      tactilePressure(layout, air, period({point(0, 0)}, Modulation::amplitude), {}, {{0, 0, 0.2f}});
  EXPECT_NEAR(alone[0], 0.5 * radiationPressure(air, focusPressure(layout, air, {0, 0, 0.2})), 0.05);
  EXPECT_EQ(tactilePressure(layout, air, {}, {}, {{0, 0, 0.2f}}), std::vector<float>{0.0f});
}

TEST(Modulation, StmRendersAPathThatCoversMoreThanFoci) {
  std::vector<contact::PressureSample> palm;
  for (int i = -10; i <= 10; ++i) {
    for (int j = -10; j <= 10; ++j) {
      if (i * i + j * j > 100) continue;
      palm.push_back({{0.004f * static_cast<float>(i), 0.004f * static_cast<float>(j), 0.2f},
                      {0, 0, -1},
                      4000.0f,
                      4000.0f * 1.6e-5f,
                      1.6e-5f,
                      1.0f});
    }
  }
  FocalPointConfig config;
  const auto foci = FocalPointRenderer(config).render(palm);
  config.modulation = Modulation::spatiotemporal;
  FocalPointRenderer renderer(config);
  const auto path = renderer.render(palm);
  EXPECT_EQ(path.size(), 32u);
  for (std::size_t k = 0; k < path.size(); ++k) EXPECT_EQ(path[k].id, k);
  EXPECT_LT(tourLength(path), 32.0 * 0.02);
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  std::vector<Eigen::Vector3f> at;
  for (const auto& s : palm) at.push_back(s.position);
  // Share of the palm within 6 dB of the strongest.
  const auto coverage = [&](const std::vector<FocalPoint>& points, Modulation mode) {
    const auto average = tactilePressure(layout, air, period(points, mode), {}, at);
    const float peak = *std::max_element(average.begin(), average.end());
    return static_cast<double>(
               std::count_if(average.begin(), average.end(), [peak](float p) { return p >= 0.25f * peak; })) /
           static_cast<double>(average.size());
  };
  EXPECT_GT(coverage(path, Modulation::spatiotemporal), 1.3 * coverage(foci, Modulation::amplitude));
}

}  // namespace
}  // namespace tactile_clay::ultrasound::modulation_test
