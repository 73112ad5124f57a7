// How bonds flow.
#include "clay/forces/flow.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "bonded.h"

namespace tactile_clay::clay::bonds_test {
namespace {

/// A lattice that was bonded, and then strained as a whole.
Bonded strained(const Eigen::Matrix3f& strain, std::vector<Material> materials = {testMaterial()}) {
  Bonded cloud(lattice(edge, spacing, 0.0f), std::move(materials));
  cloud.update();
  for (std::size_t i = 0; i < cloud.particles.size(); ++i)
    cloud.particles.position.add(i, strain * cloud.particles.position.at(i));
  cloud.near.build(cloud.particles.position);
  return cloud;
}

/// The stress that its bonds give the particle in the middle, Pa: 1/(2 V) sum k (l - d) l n n^T.
Eigen::Matrix3d stressInTheMiddle(const Bonded& cloud, double stiffness) {
  const std::uint32_t middle = (edge * edge * edge) / 2;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Bond* b = cloud.bonds.begin(middle); b != cloud.bonds.end(middle); ++b) {
    const Eigen::Vector3d x =
        (cloud.particles.position.at(middle) - cloud.particles.position.at(b->other)).cast<double>();
    sum += stiffness * (1.0 - static_cast<double>(b->rest_length) / x.norm()) * x * x.transpose();
  }
  return sum / (2.0 * std::pow(static_cast<double>(spacing), 3.0));
}
/// sqrt(s:s / 2)
double shearOf(const Eigen::Matrix3d& stress) {
  return std::sqrt(0.5) * (stress - stress.trace() / 3.0 * Eigen::Matrix3d::Identity()).norm();
}

/// Von Mises: beyond tau_y = 2 E y in shear, flow brings the stress back to tau_y and leaves its direction;
/// below it, and under pressure alone, nothing flows. The tolerance is the strain: second-order terms are
/// left out.
TEST(Flow, FlowBringsTheStressBackToYield) {
  Material m = testMaterial();
  m.yield_strain = 0.01;
  const double stiffness = m.stiffness * static_cast<double>(spacing);
  const double yield_stress = 2.0 * m.stiffness * m.yield_strain;
  Eigen::Matrix3f shear = Eigen::Matrix3f::Zero(), stretch = shear;
  shear(0, 1) = shear(1, 0) = 0.5f, stretch.diagonal() << 1.0f, -0.5f, -0.5f;
  const std::uint32_t middle = (edge * edge * edge) / 2;
  for (const Eigen::Matrix3f& direction : {shear, stretch}) {
    for (const float size : {0.018f, 0.025f, 0.04f}) {
      Bonded cloud = strained(size * direction, {m});
      const Eigen::Matrix3d before = stressInTheMiddle(cloud, stiffness);
      cloud.update();
      const Eigen::Matrix3d after = stressInTheMiddle(cloud, stiffness);
      const double expected = std::min(shearOf(before), yield_stress);
      EXPECT_NEAR(shearOf(after), expected, static_cast<double>(size) * expected) << size;
    }
  }
  Bonded pressed = strained(-0.1f * Eigen::Matrix3f::Identity(), {m});
  pressed.update();
  for (const Bond* b = pressed.bonds.begin(middle); b != pressed.bonds.end(middle); ++b) {
    const float length =
        (pressed.particles.position.at(middle) - pressed.particles.position.at(b->other)).norm();
    EXPECT_NEAR(b->rest_length, length / 0.9f, 1e-4f * spacing);
  }
}

/// Pressed evenly, a lattice has deviatoric stress at its surfaces, where bonds do not point evenly in all
/// directions. Most of what is above the yield stress flows away: in the end no particle has more than twice
/// its yield stress. If flow kept the strain of the volume alike in all bonds, edges would keep 2.7 times
/// their yield stress for ever (share 0.38).
TEST(Flow, FlowLeavesLittleStressThatCannotFlow) {
  Material m = testMaterial();
  m.yield_strain = 0.01;
  Bonded cloud = strained(-0.05f * Eigen::Matrix3f::Identity(), {m});
  const auto least = [&] {
    const auto& share = cloud.bonds.flow().share;
    return *std::min_element(share.begin(), share.begin() + edge * edge * edge);
  };
  for (int k = 0; k < 50; ++k) cloud.update();
  EXPECT_GT(least(), 0.5f);
}

/// The strain of the volume is ln det F, within twice the square of the strain, and flow keeps it within a
/// hundredth.
TEST(Flow, FlowKeepsTheStrainOfTheVolume) {
  Material m = testMaterial();
  m.yield_strain = 0.01;
  m.relaxation_time = 1.0;  // so that all particles flow a little; only their strain is measured
  const float moment = 1e-4f;
  Eigen::Matrix3f shear = Eigen::Matrix3f::Zero(), stretch = shear;
  shear(0, 1) = shear(1, 0) = 0.5f, stretch.diagonal() << 1.0f, -0.5f, -0.5f;
  const std::uint32_t middle = (edge * edge * edge) / 2;
  for (const Eigen::Matrix3f& direction : {shear, stretch}) {
    const Eigen::Matrix3f strain = 0.04f * direction - 0.01f * Eigen::Matrix3f::Identity();
    const float volume = std::log((Eigen::Matrix3f::Identity() + strain).determinant());
    Bonded cloud = strained(strain, {m});
    cloud.update(moment);
    const float told = cloud.bonds.flow().volume.normal.at(middle).sum();
    EXPECT_LT(cloud.bonds.flow().share[middle], 0.7f);
    EXPECT_NEAR(told, volume, 2.0f * strain.squaredNorm());
    cloud.update(moment);
    EXPECT_NEAR(cloud.bonds.flow().volume.normal.at(middle).sum(), told, 0.01f * std::abs(told));
  }
}

/// In simple shear by gamma a lattice has the stress E gamma, so it yields at gamma = 2 y.
TEST(Flow, YieldStressIsTwiceStiffnessTimesYieldStrain) {
  Material m = testMaterial();
  m.yield_strain = 0.01;
  Eigen::Matrix3f shear = Eigen::Matrix3f::Zero();
  shear(0, 1) = 1.0f;
  for (const float gamma : {0.0195f, 0.0205f}) {
    Bonded cloud = strained(gamma * shear, {m});
    cloud.update();
    const std::uint32_t middle = (edge * edge * edge) / 2, diagonal = middle + 1 + edge;
    const Bond* const bond = cloud.find(middle, diagonal);
    ASSERT_NE(bond, nullptr);
    const float unstrained = std::sqrt(2.0f) * spacing;
    if (gamma < 0.02f)
      EXPECT_NEAR(bond->rest_length, unstrained, 1e-6f * spacing);
    else
      EXPECT_GT(bond->rest_length, unstrained * (1.0f + 1e-4f));
  }
}

TEST(Flow, WithoutYieldNothingFlows) {
  Material elastic = testMaterial();
  elastic.yield_strain = std::numeric_limits<double>::infinity();
  Bonded pair({{0, 0, 0}, {spacing, 0, 0}}, {elastic});
  pair.update();
  for (const float length : {1e-4f * spacing, 1.9f * spacing}) {
    pair.particles.position[1].x() = length;
    pair.update();
    EXPECT_FLOAT_EQ(pair.find(0, 1)->rest_length, spacing);
  }
}

}  // namespace
}  // namespace tactile_clay::clay::bonds_test
