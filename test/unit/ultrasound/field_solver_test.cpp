#include "ultrasound/field_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <utility>

#include "support/error_of.h"
#include "ultrasound/array_reach.h"
#include "ultrasound/field_objective.h"
#include "ultrasound/focal_points.h"

namespace tactile_clay::ultrasound {
namespace {

/// Skin of finger tips above an array, pressed by a round contact each: p = p0 sqrt(1 - (d / a)^2), Hertz's.
class FieldSolver : public ::testing::Test {
 protected:
  ArrayLayout layout = arrayLayout("usx");
  Acoustics air;

  /// @param maximum Pa, in the middle of the contact
  /// @param d distance from there, radii of the contact
  static contact::PressureSample pressed(const Eigen::Vector3d& at, double maximum, double d, double step) {
    const auto area = static_cast<float>(step * step);
    const auto pressure = static_cast<float>(d < 1.0 ? maximum * std::sqrt(1.0 - d * d) : 0.0);
    return {at.cast<float>(), {0, 0, -1}, pressure, pressure * area, area, 1.0f};
  }

  /// Fingers of 8 mm in radius that look down, 33 mm of each, at places that follow from the seed.
  /// @param step m, of the samples
  /// @return samples of equal area, pressed with up to 30 kPa
  static std::vector<contact::PressureSample> fingers(unsigned seed, int count, double step) {
    std::mt19937 random(seed);
    const auto uniform = [&random] { return 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0; };
    std::vector<Eigen::Vector3d> tips;
    while (static_cast<int>(tips.size()) < count) {
      const Eigen::Vector3d tip(0.05 * uniform(), 0.05 * uniform(), 0.2 + 0.02 * uniform());
      bool free = true;
      for (const auto& other : tips) free = free && (other - tip).head<2>().norm() > 0.018;
      if (free) tips.push_back(tip);
    }
    std::vector<contact::PressureSample> skin;
    for (const Eigen::Vector3d& tip : tips) {
      const double maximum = 22500.0 + 7500.0 * uniform();
      const double radius = 0.005 + 0.001 * uniform();
      for (double x = -0.007; x < 0.0071; x += step) {
        for (double y = -0.025; y < 0.0071; y += step) {
          const double end = std::max(y, 0.0);
          const double depth = 0.008 - std::sqrt(std::max(6.4e-5 - x * x - end * end, 0.0));
          const double d = std::hypot(x, y) / radius;
          skin.push_back(pressed(tip + Eigen::Vector3d(x, y, depth), maximum, d, step));
        }
      }
    }
    return skin;
  }

  /// A tilted palm 70 mm wide, pressed on a disc of 15 to 25 mm in radius.
  static std::vector<contact::PressureSample> palm(unsigned seed, double step) {
    std::mt19937 random(seed);
    const auto uniform = [&random] { return 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0; };
    const Eigen::Vector3d middle(0.03 * uniform(), 0.03 * uniform(), 0.2 + 0.02 * uniform());
    const double slope = 0.3 * uniform(), radius = 0.02 + 0.005 * uniform();
    std::vector<contact::PressureSample> skin;
    for (double x = -0.035; x < 0.0351; x += step) {
      for (double y = -0.035; y < 0.0351; y += step) {
        const double d = std::hypot(x, y) / radius;
        skin.push_back(pressed(middle + Eigen::Vector3d(x, y, slope * x), 10000.0, d, step));
      }
    }
    return skin;
  }

  /// Of the same skin, sampled anew where nothing was asked for.
  /// @param share of the error of focal points
  template <typename SkinOf>
  void expectBetterThanFocalPoints(double share, const SkinOf& skinOf) const {
    Fit field{0.0, 0.0}, foci{0.0, 0.0};
    for (unsigned seed = 100; seed < 108; ++seed) {
      const auto fine = skinOf(seed, 0.002);
      const auto points = targets(skinOf(seed, 0.004));
      FieldSolution solution = solveField(layout, air, points);
      for (int frame = 1; frame < 6; ++frame) solution = solveField(layout, air, points, {}, solution.drives);
      const Fit of_field = fit(solution.drives, fine), of_foci = focalPoints(fine);
      field.error += of_field.error;
      field.pressure += of_field.pressure;
      foci.error += of_foci.error;
      foci.pressure += of_foci.pressure;
    }
    EXPECT_LT(field.error, share * foci.error);
    EXPECT_GT(field.pressure, 0.8 * foci.pressure);
  }

  std::vector<FocalPoint> targets(const std::vector<contact::PressureSample>& skin) const {
    FocalPointConfig config;
    config.modulation = Modulation::field;
    FocalPointRenderer renderer(config);
    renderer.setArray(ArrayReach(layout, air));
    return renderer.render(skin);
  }

  struct Fit {
    double error;     // relative RMS at the best common scale, over all of the skin
    double pressure;  // Pa, mean over the contact by force
  };

  /// Of the radiation pressure of drives that take turns, by the sum in double precision.
  Fit fit(const std::vector<Drive>& drives, const std::vector<contact::PressureSample>& skin) const {
    double both = 0.0, had = 0.0, wanted = 0.0, force = 0.0;
    for (const auto& sample : skin) {
      double given = 0.0;
      for (const Drive& drive : drives)
        given +=
            radiationPressure(air, std::abs(pressureAt(layout, air, drive, sample.position.cast<double>()))) /
            static_cast<double>(drives.size());
      both += given * sample.pressure;
      had += given * given;
      wanted += static_cast<double>(sample.pressure) * sample.pressure;
      force += sample.pressure;
    }
    return {std::sqrt(std::max(0.0, 1.0 - both * both / (had * wanted))), both / force};
  }

  Fit focalPoints(const std::vector<contact::PressureSample>& skin) const {
    FocalPointRenderer renderer;
    renderer.setArray(ArrayReach(layout, air));
    return fit({solvePhases(layout, air, renderer.render(skin)).drive}, skin);
  }

  /// The objective by its definition, in double precision.
  double objective(const std::vector<FocalPoint>& points, const std::vector<Drive>& drives,
                   const FieldSolverOptions& options) const {
    std::vector<double> intensities, wishes;
    for (const FocalPoint& point : points) {
      intensities.push_back(0.0);
      for (const Drive& drive : drives)
        intensities.back() +=
            std::norm(pressureAt(layout, air, drive, point.position)) / static_cast<double>(drives.size());
      wishes.push_back(std::pow(point.intensity * focusPressure(layout, air, point.position), 2));
    }
    double both = 0.0, had = 0.0, wanted = 0.0;
    for (std::size_t m = 0; m < points.size(); ++m) {
      double intensity = 0.0, t = 0.0, total = 0.0;  // means around m
      for (std::size_t n = 0; n < points.size(); ++n) {
        const double over_blur = (points[m].position - points[n].position).norm() / options.blur;
        const double share = options.blur > 0.0
                                 ? (over_blur <= 2.5 ? std::exp(-0.5 * over_blur * over_blur) : 0.0)
                             : m == n ? 1.0
                                      : 0.0;
        intensity += share * intensities[n];
        t += share * wishes[n];
        total += share;
      }
      intensity /= total;
      t /= total;
      both += points[m].weight * intensity * t;
      had += points[m].weight * intensity * intensity;
      wanted += points[m].weight * t * t;
    }
    const double missing = std::max(-std::log(both / wanted), 0.0);
    const double price = missing > 0.5 ? missing - 0.25 : missing * missing;
    return 1.0 - both * both / (had * wanted) + options.strength * price;
  }

  std::vector<Drive> randomDrives(std::size_t count, unsigned seed) const {
    std::mt19937 random(seed);
    std::vector<Drive> drives;
    for (std::size_t k = 0; k < count; ++k) {
      drives.push_back({{}, std::vector<float>(layout.size(), 1.0f)});
      for (std::size_t n = 0; n < layout.size(); ++n)
        drives.back().phase.push_back(static_cast<float>(2.0 * M_PI * random() / 4294967296.0));
    }
    return drives;
  }
};

TEST_F(FieldSolver, GradientIsThatOfTheObjectiveInDoublePrecision) {
  const auto even = targets(fingers(3, 2, 0.004));
  for (const auto& [patterns, blur] : {std::pair{1, 0.0}, std::pair{2, 0.0}, std::pair{1, 0.004}}) {
    auto points = even;
    for (std::size_t m = 0; blur > 0.0 && m < points.size(); ++m)
      points[m].weight = 0.25 * static_cast<double>(m % 5);
    FieldSolverOptions options;
    options.patterns = patterns;
    options.blur = blur;
    FieldObjective solver(layout, air, points, options);
    const std::vector<Drive> drives = randomDrives(static_cast<std::size_t>(patterns), 5);
    Turns turns(solver.size(), Lanes{}), gradient(solver.size());
    for (std::size_t k = 0; k < drives.size(); ++k)
      for (std::size_t n = 0; n < layout.size(); ++n)
        turns[k * solver.width() + n / wide_lane_count][n % wide_lane_count] =
            drives[k].phase[n] * static_cast<float>(0.5 / M_PI);
    const double value = solver(turns, &gradient);
    const double expected = objective(points, drives, options);
    EXPECT_NEAR(value, expected, 1e-4 * expected);

    double steepest = 0.0;
    for (const Lanes& lane : gradient)
      for (std::size_t i = 0; i < wide_lane_count; ++i)
        steepest = std::max(steepest, std::abs(double{lane[i]}));
    ASSERT_GT(steepest, 0.0);
    for (const std::size_t n : {0u, 17u, 130u, 255u}) {
      const std::size_t k = n % drives.size();
      constexpr double step = 1e-3;  // turns
      double at[2];
      for (const int side : {0, 1}) {
        std::vector<Drive> moved = drives;
        moved[k].phase[n] += static_cast<float>(2.0 * M_PI * (side == 0 ? -step : step));
        at[side] = objective(points, moved, options);
      }
      EXPECT_NEAR(gradient[k * solver.width() + n / wide_lane_count][n % wide_lane_count],
                  (at[1] - at[0]) / (2.0 * step), 5e-3 * steepest)
          << n;
    }
  }
}

TEST_F(FieldSolver, TellsTheTrueFieldAtTheTargets) {
  const auto points = targets(fingers(4, 3, 0.004));
  FieldSolverOptions options;
  options.patterns = 2;
  const FieldSolution solution = solveField(layout, air, points, options);
  FieldSolution judged = solution;
  judgeField(layout, air, points, judged);
  EXPECT_NEAR(solution.error, judged.error, 1e-3);
  EXPECT_NEAR(solution.scale, judged.scale, 1e-3 * judged.scale);
  for (std::size_t m = 0; m < points.size(); ++m) {
    EXPECT_NEAR(solution.reach[m], focusPressure(layout, air, points[m].position), 1e-4 * solution.reach[m]);
    EXPECT_DOUBLE_EQ(solution.wanted[m], points[m].intensity * solution.reach[m]);
    double square = 0.0;
    for (const Drive& drive : solution.drives)
      square += 0.5 * std::norm(pressureAt(layout, air, drive, points[m].position));
    EXPECT_NEAR(solution.reached[m], std::sqrt(square), 1e-4 * solution.reach[m]);
  }
}

// The limit that the paper names, "prevents matching large pressure areas", is one of focal points.
TEST_F(FieldSolver, HalvesTheErrorOfFocalPointsOnLargeContacts) {
  expectBetterThanFocalPoints(0.5, [](unsigned seed, double step) { return palm(seed, step); });
}

// Contacts of the size of a focus, which is what focal points are good at.
TEST_F(FieldSolver, IsBetterThanFocalPointsAlsoOnFingerTips) {
  expectBetterThanFocalPoints(
      0.7, [](unsigned seed, double step) { return fingers(seed, 1 + static_cast<int>(seed % 4), step); });
}

TEST_F(FieldSolver, TradesErrorForPressure) {
  auto points = targets(fingers(6, 3, 0.004));
  for (FocalPoint& point : points) point.intensity *= 2.0;  // more than there is
  double error = 0.0, scale = 0.0;
  for (const double strength : {0.01, 0.1, 0.5}) {
    FieldSolverOptions options;
    options.strength = strength;
    options.evaluations = 200;
    const FieldSolution solution = solveField(layout, air, points, options);
    EXPECT_GT(solution.error, error) << strength;
    EXPECT_GT(solution.scale, 1.2 * scale) << strength;
    error = solution.error;
    scale = solution.scale;
  }
}

/// As the skin feels it, blurred, a field is better where that is what it was chosen for.
TEST_F(FieldSolver, BlurFavoursWhatSkinCanTellApart) {
  double sharp_error = 0.0, blurred_error = 0.0;
  for (unsigned seed = 20; seed < 24; ++seed) {
    const auto points = targets(palm(seed, 0.004));
    FieldSolverOptions sharp, blurred;
    sharp.evaluations = blurred.evaluations = 100;
    sharp.strength = blurred.strength = 0.0;
    blurred.blur = 0.006;
    sharp_error += objective(points, solveField(layout, air, points, sharp).drives, blurred);
    blurred_error += objective(points, solveField(layout, air, points, blurred).drives, blurred);
  }
  EXPECT_LT(blurred_error, sharp_error);
}

TEST_F(FieldSolver, WeightsFavourWhatCounts) {
  auto points = targets(palm(30, 0.004));
  double middle = 0.0;
  for (const FocalPoint& point : points) middle += point.position.x() / static_cast<double>(points.size());
  const auto errorOnTheRight = [&](const FieldSolution& solution) {
    std::vector<double> wanted, reached;
    for (std::size_t m = 0; m < points.size(); ++m) {
      if (points[m].position.x() < middle) continue;
      wanted.push_back(solution.wanted[m]);
      reached.push_back(solution.reached[m]);
    }
    return fieldFit(wanted, reached).error;
  };
  const double even = errorOnTheRight(solveField(layout, air, points));
  for (FocalPoint& point : points) point.weight = point.position.x() < middle ? 0.05 : 1.0;
  EXPECT_LT(errorOnTheRight(solveField(layout, air, points)), even);
}

TEST_F(FieldSolver, GivesNoMoreThanIsWanted) {
  auto points = targets(fingers(7, 2, 0.004));
  for (FocalPoint& point : points) point.intensity *= 0.2;
  const FieldSolution solution = solveField(layout, air, points);
  EXPECT_LE(solution.scale, 1.0 + 1e-5);
  EXPECT_GT(solution.scale, 0.8) << "for so little is there";
  for (const float amplitude : solution.drives[0].amplitude)
    EXPECT_EQ(amplitude, solution.drives[0].amplitude[0]);

  FieldSolverOptions options;
  options.amplitude = 0.3;
  options.amplitude_levels = 8;
  const FieldSolution weak = solveField(layout, air, points, options);
  EXPECT_FLOAT_EQ(weak.drives[0].amplitude[0] * 8.0f, std::round(weak.drives[0].amplitude[0] * 8.0f));
  EXPECT_LE(weak.drives[0].amplitude[0], 0.3f);
  EXPECT_GT(weak.drives[0].amplitude[0], 0.0f);
}

TEST_F(FieldSolver, FollowsSkinThatMoves) {
  const auto skin = fingers(8, 3, 0.004);
  std::vector<Drive> before;
  double error = 0.0, converged = 0.0;
  for (int frame = 0; frame < 20; ++frame) {  // 0.1 m/s at 60 frames a second
    auto moved = skin;
    for (auto& sample : moved)
      sample.position += Eigen::Vector3f(0.001f, 0.0005f, 0.0012f) * static_cast<float>(frame);
    const FieldSolution solution = solveField(layout, air, targets(moved), {}, before);
    before = solution.drives;
    if (frame % 5 != 4) continue;
    error += solution.error;
    FieldSolverOptions all;
    all.evaluations = 500;
    converged += solveField(layout, air, targets(moved), all).error;
  }
  EXPECT_LT(error, 1.15 * converged);
}

TEST_F(FieldSolver, StartsAnewWhereTheFieldBeforeIsOfNoUse) {
  const auto points = targets(fingers(9, 2, 0.004));
  const FieldSolution fresh = solveField(layout, air, points);
  FieldSolution lost = solveField(layout, air, points, {}, randomDrives(1, 6));
  EXPECT_LT(lost.error, 0.6) << "one frame";
  lost = solveField(layout, air, points, {}, lost.drives);
  EXPECT_LT(lost.error, 1.2 * fresh.error) << "and the next";
}

TEST_F(FieldSolver, KeepsToThePhasesOfTheDevice) {
  const auto points = targets(fingers(10, 3, 0.004));
  const double exact = solveField(layout, air, points).error;
  for (const int levels : {16, 32}) {
    FieldSolverOptions options;
    options.phase_levels = levels;
    const FieldSolution solution = solveField(layout, air, points, options);
    for (const float phase : solution.drives[0].phase) {
      const double level = phase / (2.0 * M_PI) * levels;
      EXPECT_NEAR(level, std::round(level), 1e-4);
      EXPECT_TRUE(phase >= 0.0f && phase < 6.2832f) << phase;
    }
    EXPECT_LT(solution.error, exact + 0.02);
  }
  FieldSolverOptions options;
  options.max_phase_change = 0.3;
  const std::vector<Drive> before = randomDrives(1, 2);
  const FieldSolution limited = solveField(layout, air, points, options, before);
  for (std::size_t n = 0; n < layout.size(); ++n)
    EXPECT_LE(std::abs(std::remainder(limited.drives[0].phase[n] - before[0].phase[n], 2.0 * M_PI)),
              0.3 + 1e-4);
}

TEST_F(FieldSolver, RepeatsItselfToTheBit) {
  const auto points = targets(fingers(11, 4, 0.004));
  const auto before = randomDrives(1, 3);
  const FieldSolution once = solveField(layout, air, points, {}, before);
  const FieldSolution again = solveField(layout, air, points, {}, before);
  EXPECT_EQ(once.drives[0].phase, again.drives[0].phase);
  EXPECT_EQ(once.drives[0].amplitude, again.drives[0].amplitude);
}

TEST_F(FieldSolver, IsSilentWhereNothingIsWantedOrCanBeHad) {
  FocalPoint bare, behind;
  bare.position = {0, 0, 0.2};
  behind.position = {0, 0, -0.1};
  behind.intensity = 1.0;
  for (const std::vector<FocalPoint>& points : {std::vector<FocalPoint>{}, {bare}, {behind}}) {
    const FieldSolution solution = solveField(layout, air, points);
    ASSERT_EQ(solution.drives.size(), 1u);
    for (const float amplitude : solution.drives[0].amplitude) EXPECT_EQ(amplitude, 0.0f);
    EXPECT_EQ(solution.scale, 0.0);
  }
}

TEST_F(FieldSolver, RefusesWhatIsOutOfRange) {
  FocalPoint point;
  point.id = 5;
  point.position = {0, 0, 0.2};
  point.intensity = 1.5;
  EXPECT_EQ(errorOf<std::invalid_argument>([&] { solveField(layout, air, {point}); }),
            "field solver: intensity of target 5 is 1.500000, expected 0 to 1");
  point.intensity = 0.5;
  point.position.x() = std::nan("");
  EXPECT_EQ(errorOf<std::invalid_argument>([&] { solveField(layout, air, {point}); }),
            "field solver: position of target 5 is not finite");
  point.position.x() = 0.0;
  point.weight = -1.0;
  EXPECT_EQ(errorOf<std::invalid_argument>([&] { solveField(layout, air, {point}); }),
            "field solver: weight of target 5 is -1.000000, expected 0 or a positive number");
  point.weight = 1.0;
  FieldSolverOptions options;
  options.blur = 0.2;
  EXPECT_EQ(errorOf<std::invalid_argument>([&] { solveField(layout, air, {point}, options); }),
            "field solver: blur is 0.200000, expected 0 to 0.1 m");
  options.blur = 0.0;
  options.patterns = 3;
  EXPECT_EQ(errorOf<std::invalid_argument>([&] { solveField(layout, air, {point}, options); }),
            "field solver: patterns is 3, expected 1, 2, 4 or 8");
  EXPECT_NE(errorOf<std::invalid_argument>([&] {
              solveField(layout, air, {point}, {}, {Drive{{1.0f}, {1.0f}}});
            }).find("expected 256"),
            std::string::npos);
}

}  // namespace
}  // namespace tactile_clay::ultrasound
