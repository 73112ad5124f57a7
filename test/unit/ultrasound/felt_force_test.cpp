#include "ultrasound/felt_force.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/array_reach.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::ultrasound::felt_force_test {
namespace {

/// The radiation pressure of one focus added up over 160 mm by 160 mm of its plane, over its peak, m^2.
double areaOfFocus(const ArrayLayout& layout, const Acoustics& air, const Eigen::Vector3d& at) {
  FocalPoint focus;
  focus.position = at;
  focus.intensity = 1.0;
  const Drive drive = solvePhases(layout, air, {focus}).drive;
  constexpr double step = 0.002;  // m, a quarter of the wavelength
  std::vector<Eigen::Vector3f> plane;
  for (int row = -40; row <= 40; ++row)
    for (int column = -40; column <= 40; ++column)
      plane.push_back((at + Eigen::Vector3d(step * column, step * row, 0.0)).cast<float>());
  double total = 0.0;
  for (const auto& pressure : pressuresAt(layout, air, drive, plane))
    total += radiationPressure(air, std::abs(pressure)) * step * step;
  return total / radiationPressure(air, std::abs(pressureAt(layout, air, drive, at)));
}

// Within 5 %: transducers emit less to the side, and slanted directions do not fill a square evenly.
TEST(FeltForce, AreaOfAFocusIsThatOfItsField) {
  const Acoustics air;
  for (const char* name : {"usx", "autd3"}) {
    const ArrayLayout layout = arrayLayout(name);
    for (const Eigen::Vector3d& at : {Eigen::Vector3d(0, 0, 0.12), Eigen::Vector3d(0, 0, 0.2),
                                      Eigen::Vector3d(0.03, 0.02, 0.18), Eigen::Vector3d(-0.05, 0, 0.25)}) {
      const double area = areaOfFocus(layout, air, at);
      EXPECT_NEAR(spotArea(air, ArrayReach(layout, air).beam(at)), area, 0.05 * area)
          << name << " at " << at.transpose();
    }
  }
}

TEST(FeltForce, IsThatOfTheExperiments) {
  EXPECT_NEAR(feltForce(Modulation::lateral, 10.0, 0.027).pressure, 0.21, 1e-12);
  EXPECT_NEAR(feltForce(Modulation::circle, 5.0, 0.24 / 10.9).pressure, 0.24, 1e-12);
  EXPECT_NEAR(feltForce(Modulation::field_circle, 5.0, 1e-3).pressure, 10.9e-3, 1e-12);
  EXPECT_NEAR(feltForce(Modulation::amplitude, 200.0, 0.4e-3).vibration, 0.0, 1e-12);
  EXPECT_NEAR(feltForce(Modulation::field, 200.0, 4e-3).vibration, 20.0, 1e-12);
  EXPECT_EQ(feltForce(Modulation::field, 200.0, 0.1e-3).vibration, 0.0) << "less than is felt";
}

TEST(FeltForce, TellsNothingThatNobodyMeasured) {
  EXPECT_EQ(feltForce(Modulation::amplitude, 30.0, 4e-3).vibration, 0.0);
  EXPECT_EQ(feltForce(Modulation::amplitude, 200.0, 4e-3).pressure, 0.0);
  EXPECT_EQ(feltForce(Modulation::lateral, 50.0, 4e-3).pressure, 0.0);
  EXPECT_EQ(feltForce(Modulation::circle, 10.0, 4e-3).pressure, 0.0);
  EXPECT_EQ(feltForce(Modulation::circle, 5.0, 4e-3).vibration, 0.0);
  EXPECT_EQ(feltForce(Modulation::spatiotemporal, 50.0, 4e-3).vibration, 0.0);
  EXPECT_EQ(feltForce(Modulation::amplitude, 200.0, 0.0).vibration, 0.0);
  EXPECT_EQ(spotArea(Acoustics(), FocusBeam()), 0.0) << "behind the array";
}

}  // namespace
}  // namespace tactile_clay::ultrasound::felt_force_test
