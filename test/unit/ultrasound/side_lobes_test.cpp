#include "ultrasound/side_lobes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "oracle.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::ultrasound::side_lobes_test {
namespace {

FocalPoint point(double x, double y) {
  FocalPoint p;
  p.position = {x, y, 0.2};
  p.intensity = 1.0;
  return p;
}

TEST(SideLobes, OfASparseArrayAreItsGratingLobe) {
  // Transducers with a pitch d of more than half a wavelength have a grating lobe where the ways from
  // neighbours differ by one wavelength: sin(angle) = sin(steered) - lambda / d. For a focus 60 mm beside the
  // axis at 0.2 m, it is some 96 mm beyond the axis.
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  const std::vector<FocalPoint> foci = {point(0.06, 0.0)};
  const PhaseSolution solution = solvePhases(layout, air, foci);
  std::vector<Eigen::Vector3f> at;
  for (int i = -100; i <= 40; ++i) {
    for (int j = -10; j <= 10; ++j)
      at.emplace_back(0.002f * static_cast<float>(i), 0.004f * static_cast<float>(j), 0.2f);
  }
  const auto field = pressuresAt(layout, air, solution.drive, at);
  const SideLobe lobe = strongestSideLobe(at, field, foci, solution.reached, 2.0 * air.wavelength());
  const double sine = 0.06 / std::hypot(0.06, 0.2) - air.wavelength() / layout.pitch;
  EXPECT_NEAR(lobe.position.x(), 0.2 * sine / std::sqrt(1.0 - sine * sine), 0.03);
  EXPECT_NEAR(lobe.position.y(), 0.0, 0.012);
  EXPECT_GE((lobe.position - foci[0].position).norm(), 2.0 * air.wavelength());
  EXPECT_NEAR(lobe.share, heardAmplitude(layout, air, solution.drive, lobe.position) / solution.reached[0],
              1e-3);
  EXPECT_GT(lobe.share, 0.1);
  EXPECT_LT(lobe.share, 1.0);
}

TEST(SideLobes, OfNoFocusAreNone) {
  EXPECT_EQ(strongestSideLobe({{0, 0, 0.2f}}, {1.0f}, {}, {}, 0.01).share, 0.0);
  EXPECT_THROW(strongestSideLobe({{0, 0, 0.2f}}, {}, {}, {}, 0.01), std::invalid_argument);
}

TEST(RelativeError, IsTheSpreadAboutTheCommonScale) {
  EXPECT_NEAR(relativeError({50, 100, 150}, {100, 200, 300}), 0.0, 1e-15);
  EXPECT_NEAR(relativeError({90, 110}, {100, 100}), 0.1, 1e-15);
  EXPECT_NEAR(relativeError({90, 110, 7}, {100, 100, 0}), 0.1, 1e-15);
  EXPECT_EQ(relativeError({}, {}), 0.0);
  EXPECT_THROW(relativeError({1}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::side_lobes_test
