#include "device/loudness_meter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "device/safety_gate.h"
#include "device/sonic_surface_protocol.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::device::loudness_meter_test {
namespace {

using ultrasound::ArrayLayout;
using ultrasound::Drive;
using Points = std::vector<ultrasound::FocalPoint>;

constexpr double tolerance = 0.01;  // share of the cap
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int sets = 6;  // one of each kind
#else
constexpr int sets = 18;
#endif

/// Pressure amplitude, Pa, by a direct sum in double precision that shares nothing with the library: pistons
/// in a baffle, 2 J1(x) / x by the standard library's Bessel function.
double directSum(const ArrayLayout& layout, const ultrasound::Acoustics& air, const Drive& drive,
                 const Eigen::Vector3d& at) {
  const double k = 2.0 * M_PI * air.frequency / (331.3 * std::sqrt(1.0 + air.temperature / 273.15));
  double re = 0.0, im = 0.0;
  for (std::size_t n = 0; n < layout.size(); ++n) {
    if (drive.amplitude[n] == 0.0f) continue;
    const Eigen::Vector3d way = at - layout.position[n];
    const double along = way.dot(layout.normal[n]), r = way.norm();
    if (along <= 0.0) continue;
    const double x = k * air.transducer_radius * std::sqrt(std::max(1.0 - along * along / (r * r), 0.0));
    const double directivity = x < 1e-9 ? 1.0 : 2.0 * std::cyl_bessel_j(1.0, x) / x;
    const double level =
        air.reference_pressure * drive.amplitude[n] * directivity / r * std::exp(-air.attenuation * r);
    re += level * std::cos(k * r + drive.phase[n]);
    im += level * std::sin(k * r + drive.phase[n]);
  }
  return std::hypot(re, im);
}

/// The highest pressure in the workspace: by a dense grid, then uphill by the direct sum from its highest
/// places.
double highest(const ArrayLayout& layout, const ultrasound::Acoustics& air, const Drive& drive,
               const SafetyGateConfig& box) {
  std::vector<Eigen::Vector3f> grid;
  for (double z = box.low.z(); z < box.high.z() + 1e-9; z += z < 0.1 ? 0.004 : 0.009) {
    const double step = z < 0.1 ? 0.004 : 0.006;
    for (double y = box.low.y(); y < box.high.y() + 1e-9; y += step)
      for (double x = box.low.x(); x < box.high.x() + 1e-9; x += step)
        grid.push_back(Eigen::Vector3d(x, y, z).cast<float>());
  }
  const auto field = ultrasound::pressuresAt(layout, air, drive, grid);
  std::vector<std::size_t> order(grid.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const std::size_t maximum = std::min<std::size_t>(order.size(), 3);
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(maximum), order.end(),
                    [&](std::size_t a, std::size_t b) { return std::abs(field[a]) > std::abs(field[b]); });
  double best = 0.0;
  for (std::size_t i = 0; i < maximum; ++i) {
    Eigen::Vector3d here = grid[order[i]].cast<double>();
    double pressure = directSum(layout, air, drive, here);
    for (double step = 0.002; step > 0.0002;) {
      bool moved = false;
      for (int n = 0; n < 27; ++n) {
        const Eigen::Vector3d way(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
        const Eigen::Vector3d there = (here + step * way).cwiseMax(box.low).cwiseMin(box.high);
        const double now = directSum(layout, air, drive, there);
        if (now <= pressure) continue;
        pressure = now;
        here = there;
        moved = true;
        break;
      }
      if (!moved) step *= 0.5;
    }
    best = std::max(best, pressure);
  }
  return best;
}

/// Seeded sets of 1 to 16 points: anywhere, close together, the same place, in a row, at the edges, near the
/// array.
class PointSets {
 public:
  static constexpr int kinds = 6;

  Points next(int kind) {
    Points points(static_cast<std::size_t>(1 + between(0.0, 16.0)));
    const Eigen::Vector3d middle(between(-0.12, 0.12), between(-0.12, 0.12), between(0.06, 0.3));
    const Eigen::Vector3d row =
        Eigen::Vector3d(between(-1, 1), between(-1, 1), between(-1, 1)).normalized() * between(0.005, 0.08);
    const double size = std::pow(10.0, between(-4.0, -1.7));  // m
    if (kind == 1 || kind == 2) points.resize(std::min<std::size_t>(points.size(), 4));
    for (std::size_t k = 0; k < points.size(); ++k) {
      points[k].id = static_cast<std::uint32_t>(between(0, 3));
      points[k].intensity = between(0.0, 1.0) < 0.5 ? 1.0 : between(0.0, 1.0);
      Eigen::Vector3d& x = points[k].position;
      switch (kind) {
        case 0:
          x = {between(-0.1, 0.1), between(-0.1, 0.1), between(0.1, 0.3)};
          break;
        case 1:
          x = middle + size * Eigen::Vector3d(between(-1, 1), between(-1, 1), between(-1, 1));
          break;
        case 2:
          x = middle;
          break;
        case 3:
          x = middle + static_cast<double>(k) / 16.0 * row;
          break;
        case 4:
          x = {between(0, 1) < 0.5 ? -0.2 : 0.2, between(-0.2, 0.2), between(0.05, 0.4)};
          break;
        default:
          x = {between(-0.1, 0.1), between(-0.1, 0.1), 0.05 + 0.03 * between(0, 1) * between(0, 1)};
      }
      x = x.cwiseMax(Eigen::Vector3d(-0.2, -0.2, 0.05)).cwiseMin(Eigen::Vector3d(0.2, 0.2, 0.4));
    }
    return points;
  }

 private:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  std::mt19937 random_{31};
};

/// Judges again the sound that a gate lets through for a set of points.
void expectBelowTheCap(const ArrayLayout& layout, const Instrument& array, const SafetyGateConfig& config,
                       const ultrasound::Acoustics& air, int count) {
  SafetyGate gate(config, array);
  gate.start();
  PointSets random;
  int lowered = 0, close_to_cap = 0;
  for (int k = 0; k < count; ++k) {
    gate.fallSilent();
    Occasion occasion;
    occasion.since_last = 1.0;
    const Verdict verdict = gate.check({random.next(k % PointSets::kinds), 200.0}, occasion);
    if (!verdict.passes()) {
      ADD_FAILURE() << "set " << k << ": " << verdict.reason;
      continue;
    }
    lowered += verdict.lowered.empty() ? 0 : 1;
    for (const Sound::Part& part : verdict.sound.parts) {
      const double pressure = highest(layout, air, part.drive, config);
      EXPECT_LE(pressure, (1.0 + tolerance) * config.pressure_cap)
          << "set " << k << " of " << part.what.points.size() << " points, " << verdict.lowered;
      close_to_cap += pressure > 0.95 * config.pressure_cap ? 1 : 0;
    }
  }
  EXPECT_GE(lowered, count / 8) << "the cap is asked for";
  EXPECT_GE(close_to_cap, lowered / 2) << "and no more is taken than it asks for";
}

Instrument solved(const ArrayLayout& layout, const ultrasound::Acoustics& air,
                  const SafetyGateConfig& config) {
  const auto meter = std::make_shared<LoudnessMeter>(layout, air, Eigen::Vector3d(-0.4, 0, 0.6), config);
  return {[=](const Points& points, const Drive*) { return ultrasound::solvePhases(layout, air, points); },
          [meter](const Drive& drive, const Points& points) { return (*meter)(drive, points); }, true};
}

SafetyGateConfig pressureAlone(double cap) {
  SafetyGateConfig config;
  config.head_spl_cap = 200.0;
  config.pressure_cap = cap;
  return config;
}

TEST(LoudnessMeter, CapsHoldAnywhereInTheWorkspace) {
  const ArrayLayout layout = ultrasound::arrayLayout("usx");
  ultrasound::Acoustics air;
  expectBelowTheCap(layout, solved(layout, air, pressureAlone(2000.0)), pressureAlone(2000.0), air, sets);
  air.temperature = 35.0;
  expectBelowTheCap(layout, solved(layout, air, pressureAlone(800.0)), pressureAlone(800.0), air, sets / 3);
}

/// Two arrays that face each other: standing waves between them.
TEST(LoudnessMeter, CapsHoldBetweenTwoArrays) {
  const ArrayLayout layout = ultrasound::arrayLayouts("usx; usx 0 0 0.45 3.14159265 0 0");
  const ultrasound::Acoustics air;
  expectBelowTheCap(layout, solved(layout, air, pressureAlone(2000.0)), pressureAlone(2000.0), air, sets / 3);
}

/// Boards that switch channels off, with few phases.
TEST(LoudnessMeter, CapsHoldForBoards) {
  const ArrayLayout layout = ultrasound::arrayLayout("sonic_surface");
  const ultrasound::Acoustics air;
  Instrument array = solved(layout, air, pressureAlone(1200.0));
  array.scalable = false;
  array.solve = [&](const Points& points, const Drive*) {
    ultrasound::PhaseSolution solution = ultrasound::solvePhases(layout, air, points);
    solution.drive = sonic_surface::emitted(solution.drive, sonic_surface::Firmware::tactile);
    return solution;
  };
  expectBelowTheCap(layout, array, pressureAlone(1200.0), air, sets / 3);
}

/// Fields: the gate looks at each pattern, on the skin and beside it.
TEST(LoudnessMeter, CapsHoldForFields) {
  const ArrayLayout layout = ultrasound::arrayLayout("usx");
  const ultrasound::Acoustics air;
  const SafetyGateConfig config = pressureAlone(700.0);
  Instrument array = solved(layout, air, config);
  array.solve_field = [&](const Points& targets, double amplitude, const std::vector<Drive>& before, double) {
    ultrasound::FieldSolverOptions options;
    options.amplitude = amplitude;
    options.patterns = 2;
    return ultrasound::solveField(layout, air, targets, options, before);
  };
  SafetyGate gate(config, array);
  gate.start();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-0.05, 0.05);
  int lowered = 0;
  for (int k = 0; k < 6; ++k) {
    gate.fallSilent();
    Points skin;
    const Eigen::Vector3d middle(place(random), place(random), 0.18 + 0.5 * place(random));
    for (int i = -5; i <= 5; ++i)
      for (int j = -5; j <= 5; ++j) {
        ultrasound::FocalPoint sample;
        sample.position = middle + Eigen::Vector3d(0.005 * i, 0.005 * j, 0.0);
        sample.intensity = std::hypot(i, j) < 2.5 ? 0.6 : 0.0;
        skin.push_back(sample);
      }
    Occasion occasion;
    occasion.since_last = 1.0;
    const Verdict verdict = gate.check({skin, 200.0, ultrasound::Modulation::field}, occasion);
    ASSERT_TRUE(verdict.passes()) << verdict.reason;
    ASSERT_EQ(verdict.sound.parts.size(), 2u);
    lowered += verdict.lowered.empty() ? 0 : 1;
    for (const Sound::Part& part : verdict.sound.parts)
      EXPECT_LE(highest(layout, air, part.drive, config), (1.0 + tolerance) * config.pressure_cap);
  }
  EXPECT_GE(lowered, 3) << "the cap is asked for";
}

/// Two points 1 mm apart: the highest place is 8 mm beside them.
TEST(LoudnessMeter, LooksBesideThePoints) {
  const ArrayLayout layout = ultrasound::arrayLayout("usx");
  const ultrasound::Acoustics air;
  const LoudnessMeter meter(layout, air, {-0.4, 0, 0.6}, pressureAlone(1000.0));
  Points points(2);
  points[0].position = {-0.0005, 0, 0.2};
  points[1].position = {0.0005, 0, 0.2};
  points[0].intensity = 1.0;
  points[1].intensity = 0.6;
  const Drive drive = ultrasound::solvePhases(layout, air, points).drive;
  double at_points = 0.0;
  for (const auto& point : points)
    at_points = std::max(at_points, std::abs(ultrasound::pressureAt(layout, air, drive, point.position)));
  const Loudness loudness = meter(drive, points);
  EXPECT_GT(*loudness.pressure, 1.1 * at_points);
  EXPECT_NEAR(*loudness.pressure / highest(layout, air, drive, pressureAlone(1000.0)), 1.0, tolerance);
}

}  // namespace
}  // namespace tactile_clay::device::loudness_meter_test
