#include "ultrasound/focus_peak.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "oracle.h"
#include "ultrasound/phase_solver.h"

namespace tactile_clay::ultrasound::focus_peak_test {
namespace {

TEST(PeakNear, IsTheTopOfAHill) {
  const Eigen::Vector3d top(0.003, -0.004, 0.2);
  const auto hill = [&](const Eigen::Vector3d& at) { return -(at - top).squaredNorm(); };
  for (const double z : {0.2, 0.25}) {
    const Eigen::Vector3d found = peakNear({0.0, 0.0, z}, hill);
    EXPECT_LE((found.head<2>() - top.head<2>()).norm(), 0.0002) << "its steps end at 0.2 mm";
    EXPECT_EQ(found.z(), z) << "in the plane of the point";
  }
}

TEST(PeakNear, IsNoFartherThanEightMillimetres) {
  const auto slope = [](const Eigen::Vector3d& at) { return at.x(); };
  const double way = peakNear(Eigen::Vector3d::Zero(), slope).norm();
  EXPECT_LE(way, 0.008);
  EXPECT_GE(way, 0.0075);
  EXPECT_EQ(peakNear(Eigen::Vector3d::Zero(), [](const auto&) { return 1.0; }).norm(), 0.0) << "flat";
}

/// One focus, and points beside it: a point has its peak if a climb in the field of another formula ends
/// within the radius.
TEST(PeaksWithin, AreThoseThatAClimbFinds) {
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  FocalPoint focus;
  focus.position = {0.01, 0.02, 0.18};
  focus.intensity = 1.0;
  const Drive drive = solvePhases(layout, air, {focus}).drive;
  for (const double aside : {0.0, 0.001, 0.0015, 0.0025, 0.004}) {
    for (const double angle : {0.0, 1.0, 2.5, 4.0}) {
      FocalPoint point = focus;
      point.position += aside * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
      const auto heard = [&](const Eigen::Vector3d& at) { return heardAmplitude(layout, air, drive, at); };
      const bool near = (peakNear(point.position, heard) - point.position).norm() < 0.002;
      EXPECT_EQ(near, aside < 0.002) << "else this test tests nothing";
      EXPECT_EQ(peaksWithin(0.002, layout, air, drive, {point}), near ? 1u : 0u) << aside << " " << angle;
    }
  }
}

TEST(PeaksWithin, OfSilenceAreNone) {
  const ArrayLayout layout = arrayLayout("usx");
  const Acoustics air;
  const Drive silent{std::vector<float>(256, 0.0f), std::vector<float>(256, 0.0f)};
  FocalPoint point;
  point.position = {0.0, 0.0, 0.2};
  EXPECT_EQ(peaksWithin(0.002, layout, air, silent, {point}), 0u);
  EXPECT_EQ(peaksWithin(0.002, layout, air, silent, {}), 0u);
  point.position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(peaksWithin(0.002, layout, air, silent, {point}), 0u);
  EXPECT_THROW(peaksWithin(0.002, layout, air, Drive{}, {point}), std::invalid_argument);
}

}  // namespace
}  // namespace tactile_clay::ultrasound::focus_peak_test
