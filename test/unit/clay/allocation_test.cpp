// After its first frames, the clay allocates no memory, or little.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clay/clay.h"
#include "clay/neighbourhood.h"
#include "clouds.h"
#include "counted_new.h"
#include "support/setups.h"

namespace tactile_clay::clay::allocation_test {
namespace {

/// A cloud turns about the vertical, so that its grid and its lists change in every build.
TEST(Allocation, WarmSearchForNeighboursAllocatesNothing) {
  const std::vector<Eigen::Vector3f> points = lattice(14, 0.005f, 0.3f);
  VectorField at = toField(points);
  Neighbourhood near(0.01f);
  const auto turnOnce = [&] {
    for (int k = 0; k < 60; ++k) {
      const Eigen::AngleAxisf turn(static_cast<float>(2.0 * M_PI * k / 60), Eigen::Vector3f::UnitZ());
      for (std::size_t i = 0; i < points.size(); ++i) at.set(i, turn * points[i]);
      near.build(at);
    }
  };
  const long before_first = allocationCount();
  turnOnce();
  EXPECT_GT(allocationCount(), before_first);
  const long before = allocationCount();
  turnOnce();
  EXPECT_EQ(allocationCount(), before);
}

/// A plate of skin kneads a block on a table, up and down. A frame allocates for its lists of lumps, some
/// twenty times per step, and nothing per particle or contact.
TEST(Allocation, WarmFramesAllocateForNoParticleOrContact) {
  ClayConfig config;
  config.spacing = 0.005;
  config.threads = 2;
  Clay clay(config, {Material{}}, block(10, 10, 8, config.spacing));
  std::size_t contacts = 0;
  const auto maxOfAStroke = [&] {
    long maximum = 0;
    for (int k = 0; k < 60; ++k) {
      const double phase = 2.0 * M_PI * k / 60, height = 0.035 + 0.01 * std::cos(phase);
      Skin skin = samplePlane({0.0, 0.0, height}, -Eigen::Vector3d::UnitZ(), 0.03, 0.004);
      for (Eigen::Vector3f& v : skin.velocity)
        v.z() = static_cast<float>(-0.01 * std::sin(phase) * 2.0 * M_PI);
      const long before = allocationCount();
      clay.advance(skin, {ground()}, 1.0 / 60.0);
      maximum = std::max<long>(maximum, allocationCount() - before);
      contacts = std::max<std::size_t>(contacts, clay.statistics().contacts);
    }
    return maximum;
  };
  maxOfAStroke();
  EXPECT_LT(maxOfAStroke(), 150);
  EXPECT_GT(contacts, 150U);
}

}  // namespace
}  // namespace tactile_clay::clay::allocation_test
