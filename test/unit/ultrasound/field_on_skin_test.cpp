#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <vector>

#include "field_solver_fixture.h"
#include "on_skin.h"
#include "ultrasound/field_solver.h"

namespace tactile_clay::ultrasound::field_on_skin_test {
namespace {

/// Outward normal of skin that looks down and is turned by this angle about y, rad.
Eigen::Vector3d turned(double angle) {
  return {std::sin(angle), 0.0, -std::cos(angle)};
}

class FieldOnSkin : public FieldSolver {
 protected:
  /// Squared amplitude on skin there, over that without skin.
  double share(const ArrayLayout& array, const Drive& drive, const Eigen::Vector3d& at, double angle) const {
    const std::vector<Eigen::Vector3f> where = {at.cast<float>()};
    const auto on_skin = pressuresAt(array, air, drive, where, {turned(angle).cast<float>()});
    return static_cast<double>(std::norm(on_skin[0]) / std::norm(pressuresAt(array, air, drive, where)[0]));
  }

  /// The drive that has all transducers in phase at a place.
  Drive focusAt(const Eigen::Vector3d& at) const {
    Drive drive{{}, std::vector<float>(layout.size(), 1.0f)};
    for (std::size_t n = 0; n < layout.size(); ++n)
      drive.phase.push_back(static_cast<float>(
          -std::remainder(air.wavenumber() * (at - layout.position[n]).norm(), 2.0 * M_PI)));
    return drive;
  }
};

// I = |p|^2 cos^2 of the incidence: exactly for one wave; for an array 1 m away, whose waves come from
// directions within 7 degrees, within 0.02.
TEST_F(FieldOnSkin, PressureGoesWithTheSquareOfTheCosine) {
  ArrayLayout one = layout;
  one.position.assign(1, {0.0, 0.0, 0.0});
  one.normal.assign(1, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d at(0.0, 0.0, 1.0);
  for (const double angle : {0.0, 0.3, 0.7, 1.1, 1.5}) {
    EXPECT_NEAR(share(one, {{0.0f}, {1.0f}}, at, angle), std::pow(std::cos(angle), 2), 1e-5) << angle;
    EXPECT_NEAR(share(layout, focusAt(at), at, angle), std::pow(std::cos(angle), 2), 0.02) << angle;
  }
}

TEST_F(FieldOnSkin, NothingPressesOnSkinThatFacesAway) {
  const Eigen::Vector3d at(0.0, 0.0, 0.2);
  EXPECT_EQ(share(layout, focusAt(at), at, M_PI), 0.0);
  // Skin in the plane of the focus and the axis faces one half of the array: the other half counts as 0.
  EXPECT_NEAR(
      std::abs(pressuresAt(layout, air, focusAt(at), {at.cast<float>()}, {Eigen::Vector3f::UnitX()})[0]),
      std::abs(amplitudeOnSkin(layout, air, focusAt(at), at, Eigen::Vector3d::UnitX())), 0.5);
  EXPECT_GT(share(layout, focusAt(at), at, 0.5 * M_PI), 0.005);
  FocalPoint away;
  away.position = at;
  away.intensity = 0.5;
  away.normal = Eigen::Vector3d::UnitZ();
  const FieldSolution solution = solveField(layout, air, {away});
  EXPECT_GT(solution.wanted[0], 0.0);
  EXPECT_EQ(solution.on_skin[0], 0.0);
  EXPECT_EQ(solution.error, 1.0);
  EXPECT_EQ(solution.drives[0].amplitude, std::vector<float>(layout.size(), 0.0f)) << "no sound for nothing";
}

// The radiation pressure on a plane rigid wall by its definition, <P^2>/(2 rho c^2) - rho <v^2>/2. The array
// and its mirror image make the field, so P is twice the pressure without wall, and v follows from its slope
// along the wall. That is also what the amplitude on skin stands for: the same force within 5 %. The pressure
// is the same but for the spread of directions from which a focus gets its waves, within 0.08 / cos^2 (RMS):
// 8 % head-on, 27 % at 57 degrees. The force of the field without wall is off by more.
TEST_F(FieldOnSkin, IsTheRadiationPressureOfARigidWall) {
  const Eigen::Vector3d focus(0.0, 0.0, 0.2);
  const Drive drive = focusAt(focus);
  const auto p = [&](const Eigen::Vector3d& at) { return pressureAt(layout, air, drive, at); };
  for (const double angle : {0.0, 0.5, 1.0}) {
    const Eigen::Vector3d normal = turned(angle), across(std::cos(angle), 0.0, std::sin(angle)),
                          along = Eigen::Vector3d::UnitY();
    std::vector<Eigen::Vector3d> places;
    std::vector<Eigen::Vector3f> at;
    for (double a = -0.05; a < 0.0501; a += 0.002)
      for (double b = -0.03; b < 0.0301; b += 0.002) {
        places.push_back(focus + a * across + b * along);
        at.push_back(places.back().cast<float>());
      }
    const auto field =
        pressuresAt(layout, air, drive, at, std::vector<Eigen::Vector3f>(at.size(), normal.cast<float>()));
    double wall = 0.0, on_skin = 0.0, free = 0.0, apart = 0.0, square = 0.0;
    for (std::size_t i = 0; i < at.size(); ++i) {
      constexpr double step = 2e-5;  // m
      double slope = 0.0;            // squared, of the pressure along the wall
      for (const Eigen::Vector3d& way : {across, along})
        slope += std::norm((p(places[i] + step * way) - p(places[i] - step * way)) / (2.0 * step));
      const double langevin = std::norm(p(places[i])) - slope / std::pow(air.wavenumber(), 2);
      const double ours = std::norm(std::complex<double>(field[i]));
      wall += langevin;
      on_skin += ours;
      free += std::norm(p(places[i]));
      apart += std::pow(ours - langevin, 2);
      square += std::pow(langevin, 2);
    }
    EXPECT_NEAR(on_skin, wall, 0.05 * wall) << angle;
    EXPECT_LT(std::sqrt(apart / square), 0.08 / std::pow(std::cos(angle), 2)) << angle;
    EXPECT_GT(free, (angle > 0.4 ? 1.2 : 0.9) * wall) << angle;
  }
}

// The gate bounds the pressure without skin. That also bounds the amplitude on skin: by Bernstein's
// inequality the slope of a sum of plane waves is nowhere above k times its highest amplitude.
TEST_F(FieldOnSkin, NoSkinIsPressedHarderThanTheSoundAroundItIsLoud) {
  std::mt19937 random(8);
  const auto uniform = [&random] { return 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0; };
  for (unsigned trial = 0; trial < 40; ++trial) {
    const Eigen::Vector3d at(0.06 * uniform(), 0.06 * uniform(), 0.2 + 0.06 * uniform());
    const Eigen::Vector3d away(0.01 * uniform(), 0.01 * uniform(), 0.01 * uniform());
    const Drive drive = trial % 2 == 0 ? randomDrives(1, trial)[0] : focusAt(at + away);
    const Eigen::Vector3d normal = Eigen::Vector3d(uniform(), uniform(), -1.0).normalized();
    double around = 0.0;
    for (double x = -0.008; x < 0.0081; x += 0.002)
      for (double y = -0.008; y < 0.0081; y += 0.002)
        for (double z = -0.008; z < 0.0081; z += 0.002)
          around = std::max(around, std::abs(pressureAt(layout, air, drive, at + Eigen::Vector3d(x, y, z))));
    const auto on_skin = pressuresAt(layout, air, drive, {at.cast<float>()}, {normal.cast<float>()});
    EXPECT_LE(static_cast<double>(std::abs(on_skin[0])), around) << trial;
  }
}

TEST_F(FieldOnSkin, TheRendererGivesTheNormalOfEachSample) {
  auto skin = palm(5, 0.004);
  for (const FocalPoint& point : targets(skin))
    EXPECT_LT((point.normal - skin[0].normal.cast<double>()).norm(), 1e-6) << "a palm is flat";
  EXPECT_LT(skin[0].normal.z(), -0.9f);
  skin[3].normal.x() = std::nanf("");
  EXPECT_EQ(targets(skin).size(), skin.size() - 1) << "such a sample is left out";
}

TEST_F(FieldOnSkin, WithoutNormalsThereIsNoSkin) {
  auto points = targets(fingers(4, 3, 0.004));
  std::vector<Eigen::Vector3f> at;
  for (FocalPoint& point : points) {
    point.normal.setZero();
    at.push_back(point.position.cast<float>());
  }
  const FieldSolution solution = solveField(layout, air, points);
  EXPECT_EQ(solution.on_skin, solution.reached);
  const std::vector<Eigen::Vector3f> none(at.size(), Eigen::Vector3f::Zero());
  const auto free = pressuresAt(layout, air, solution.drives[0], at);
  const auto zero = pressuresAt(layout, air, solution.drives[0], at, none);
  for (std::size_t m = 0; m < at.size(); ++m) {
    EXPECT_LT(std::abs(zero[m] - free[m]), 1e-4 * solution.reach[m]);
    EXPECT_NEAR(solution.on_skin[m],
                std::abs(pressureAt(layout, air, solution.drives[0], points[m].position)),
                1e-4 * solution.reach[m]);
  }
  EXPECT_THROW(pressuresAt(layout, air, solution.drives[0], at, {none[0]}), std::invalid_argument);
  points[1].normal.x() = std::nan("");
  EXPECT_THROW(solveField(layout, air, points), std::invalid_argument);
}

TEST_F(FieldOnSkin, IsBetterThanFocalPointsOnRoundFingers) {
  expectBetterThanFocalPoints(0.75, [](unsigned seed, double step) {
    return fingers(seed, 1 + static_cast<int>(seed % 4), step, true);
  });
}

/// Two patches of skin that want the same pressure, one that faces the array and one at 60 degrees to it.
/// @return pressure on the second over that on the first, mean over each patch
TEST_F(FieldOnSkin, SkinAtAnAnglePressesAsMuchAsItShould) {
  const auto ratio = [&](bool told) {
    std::vector<FocalPoint> points;
    std::vector<Eigen::Vector3d> normals;
    for (const double angle : {0.0, M_PI / 3.0})
      for (double a = -0.012; a < 0.0121; a += 0.004)
        for (double b = -0.012; b < 0.0121; b += 0.004) {
          FocalPoint& point = points.emplace_back();
          point.position = Eigen::Vector3d(angle == 0.0 ? -0.03 : 0.03, b, 0.2) +
                           a * Eigen::Vector3d(std::cos(angle), 0.0, std::sin(angle));
          point.intensity = std::hypot(a, b) < 0.009 ? 0.15 : 0.0;
          normals.push_back(turned(angle));
          if (told) point.normal = 3.0 * normals.back();  // its length does not count
        }
    const FieldSolution solution = solveField(layout, air, points);
    double sum[2] = {0.0, 0.0};
    for (std::size_t m = 0; m < points.size(); ++m) {
      if (!(points[m].intensity > 0.0)) continue;
      const double amplitude =
          std::abs(amplitudeOnSkin(layout, air, solution.drives[0], points[m].position, normals[m]));
      if (told) {
        EXPECT_NEAR(solution.on_skin[m], amplitude, 1e-4 * solution.reach[m]);
      }
      sum[m < points.size() / 2 ? 0 : 1] += amplitude * amplitude;
    }
    return sum[1] / sum[0];
  };
  EXPECT_NEAR(ratio(true), 1.0, 0.25);
  EXPECT_LT(ratio(false), 0.45) << "so much is lost if the solver does not know the angle";
}

}  // namespace
}  // namespace tactile_clay::ultrasound::field_on_skin_test
