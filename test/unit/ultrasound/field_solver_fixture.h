#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "contact/pressure_field.h"
#include "on_skin.h"
#include "ultrasound/array_reach.h"
#include "ultrasound/field_solver.h"
#include "ultrasound/focal_points.h"
#include "ultrasound/phase_solver.h"

/// What the tests of the field solver share: pressed skin, and how well drives make its pressures.
namespace tactile_clay::ultrasound {

/// Skin of finger tips above an array, pressed by a round contact each: p = p0 sqrt(1 - (d / a)^2), Hertz's.
class FieldSolver : public ::testing::Test {
 protected:
  ArrayLayout layout = arrayLayout("usx");
  Acoustics air;

  /// @param maximum Pa, in the middle of the contact
  /// @param d distance from there, radii of the contact
  /// @param slope of the skin, dz/dx and dz/dy
  static contact::PressureSample pressed(const Eigen::Vector3d& at, double maximum, double d, double step,
                                         const Eigen::Vector2d& slope = {0.0, 0.0}) {
    const auto area = static_cast<float>(step * step);
    const auto pressure = static_cast<float>(d < 1.0 ? maximum * std::sqrt(1.0 - d * d) : 0.0);
    const Eigen::Vector3d normal = Eigen::Vector3d(slope.x(), slope.y(), -1.0).normalized();
    return {at.cast<float>(), normal.cast<float>(), pressure, pressure * area, area, 1.0f};
  }

  /// Fingers with a radius of 8 mm that face down, 33 mm of each, at places that depend on the seed.
  /// @param step m, between samples
  /// @return samples of equal area, pressed with up to 30 kPa
  /// @param round whether the normals are those of the round skin; otherwise all skin looks down
  static std::vector<contact::PressureSample> fingers(unsigned seed, int count, double step,
                                                      bool round = false) {
    std::mt19937 random(seed);
    const auto uniform = [&random] { return 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0; };
    std::vector<Eigen::Vector3d> tips;
    while (static_cast<int>(tips.size()) < count) {
      const Eigen::Vector3d tip(0.05 * uniform(), 0.05 * uniform(), 0.2 + 0.02 * uniform());
      bool free = true;
      for (const auto& other : tips) free = free && (other - tip).head<2>().norm() > 0.018;
      if (free) tips.push_back(tip);
    }
    const Eigen::Vector2d flat(0.0, 0.0);
    std::vector<contact::PressureSample> skin;
    for (const Eigen::Vector3d& tip : tips) {
      const double maximum = 22500.0 + 7500.0 * uniform();
      const double radius = 0.005 + 0.001 * uniform();
      for (double x = -0.007; x < 0.0071; x += step) {
        for (double y = -0.025; y < 0.0071; y += step) {
          const double end = std::max(y, 0.0);
          const double depth = 0.008 - std::sqrt(std::max(6.4e-5 - x * x - end * end, 0.0));
          const double d = std::hypot(x, y) / radius;
          const Eigen::Vector2d slope = Eigen::Vector2d(x, end) / std::max(0.008 - depth, 1e-4);
          skin.push_back(pressed(tip + Eigen::Vector3d(x, y, depth), maximum, d, step, round ? slope : flat));
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
        skin.push_back(pressed(middle + Eigen::Vector3d(x, y, slope * x), 10000.0, d, step, {slope, 0.0}));
      }
    }
    return skin;
  }

  /// Compares errors on the same skin, sampled more finely than for the solver.
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
    config.field_normals = true;
    FocalPointRenderer renderer(config);
    renderer.setArray(ArrayReach(layout, air));
    return renderer.render(skin);
  }

  struct Fit {
    double error;     // relative RMS at the best common scale, over all of the skin
    double pressure;  // Pa, mean over the contact by force
  };

  /// Error of the radiation pressure on skin of drives that take turns, by the sum in double precision.
  Fit fit(const std::vector<Drive>& drives, const std::vector<contact::PressureSample>& skin) const {
    double both = 0.0, had = 0.0, wanted = 0.0, force = 0.0;
    for (const auto& sample : skin) {
      double given = 0.0;
      for (const Drive& drive : drives)
        given += radiationPressure(
                     air, std::abs(amplitudeOnSkin(layout, air, drive, sample.position.cast<double>(),
                                                   sample.normal.cast<double>()))) /
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
        intensities.back() += std::norm(amplitudeOnSkin(layout, air, drive, point.position, point.normal)) /
                              static_cast<double>(drives.size());
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

}  // namespace tactile_clay::ultrasound
