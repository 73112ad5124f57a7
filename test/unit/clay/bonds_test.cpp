#include "clay/forces/bonds.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>

#include "clouds.h"

namespace tactile_clay::clay::bonds_test {
namespace {

constexpr float spacing = 0.005f;
constexpr int edge = 7;  // particles, of lattices whose middle no surface reaches

Material testMaterial() {
  Material m;
  m.stiffness = 1e5;
  m.bond_rate = 1.0;
  m.unbond_rate = 10.0;
  m.yield_strain = 0.1;
  return m;
}

/// Particles, and the bonds between them.
struct Bonded {
  explicit Bonded(const std::vector<Eigen::Vector3f>& points,
                  std::vector<Material> materials = {testMaterial()})
      : particles(particlesAt(points, 2e-4f)), bonds(spacing, materials), near(2.0f * spacing) {}

  /// @param duration s, in which stress relaxes
  void update(float duration = 0.0f) {
    near.build(particles.position);
    bonds.update(near, particles, particles.velocity, true, duration);
  }
  const Bond* find(std::uint32_t i, std::uint32_t j) const {
    for (const Bond* b = bonds.begin(i); b != bonds.end(i); ++b) {
      if (b->other == j) return b;
    }
    return nullptr;
  }

  Particles particles;
  Bonds bonds;
  Neighbourhood near;
};

/// Two particles a spacing apart, parting at `rate` (1/s, of their distance).
Bonded pairParting(float rate) {
  Bonded pair({{0, 0, 0}, {spacing, 0, 0}});
  pair.particles.velocity[1].x() = rate * spacing;
  return pair;
}

TEST(Bonds, FormBelowTheBondRateAndNotAbove) {
  for (const float rate : {0.0f, 0.9f, -0.9f}) {
    Bonded pair = pairParting(rate);
    pair.update();
    EXPECT_EQ(pair.bonds.size(), 1u) << rate;
    EXPECT_FLOAT_EQ(pair.find(0, 1)->rest_length, spacing);
  }
  for (const float rate : {1.1f, -1.1f}) {
    Bonded pair = pairParting(rate);
    pair.update();
    EXPECT_EQ(pair.bonds.size(), 0u) << rate;
  }
}

TEST(Bonds, SurviveUpToTheUnbondRateAndBreakAbove) {
  Bonded pair = pairParting(0.0f);
  pair.update();
  for (const float rate : {1.1f, 5.0f, 9.9f, -9.9f}) {
    pair.particles.velocity[1].x() = rate * spacing;
    pair.update();
    EXPECT_EQ(pair.bonds.size(), 1u) << rate;
  }
  pair.particles.velocity[1].x() = 10.1f * spacing;
  pair.update();
  EXPECT_EQ(pair.bonds.size(), 0u);
  // hysteresis: what kept a bond alive does not make one
  pair.particles.velocity[1].x() = 5.0f * spacing;
  pair.update();
  EXPECT_EQ(pair.bonds.size(), 0u);
}

TEST(Bonds, SlidingPastEachOtherIsNoStretch) {
  Bonded pair = pairParting(0.0f);
  pair.update();
  pair.particles.velocity[1].y() = 1.0f;
  pair.update();
  EXPECT_EQ(pair.bonds.size(), 1u);
}

TEST(Bonds, KeepTheirRestLengthAndFormOnlyWithinReach) {
  Bonded pair = pairParting(0.0f);
  pair.update();
  pair.particles.position[1].x() = 1.05f * spacing;
  pair.update();
  EXPECT_FLOAT_EQ(pair.find(0, 1)->rest_length, spacing);
  pair.particles.position[1].x() = 1.6f * spacing;  // what bonded within reach stays bonded beyond
  pair.update();
  EXPECT_EQ(pair.bonds.size(), 1u);
  Bonded far({{0, 0, 0}, {1.6f * spacing, 0, 0}});
  far.update();
  EXPECT_EQ(far.bonds.size(), 0u);
  Bonded near({{0, 0, 0}, {1.4f * spacing, 0, 0}});
  near.update();
  EXPECT_EQ(near.bonds.size(), 1u);
}

TEST(Bonds, NoneWithoutStiffnessAndNoneBetweenCoincidentParticles) {
  Material loose = testMaterial();
  loose.stiffness = 0.0;
  Bonded none({{0, 0, 0}, {spacing, 0, 0}}, {loose});
  none.update();
  EXPECT_EQ(none.bonds.size(), 0u);
  Bonded coincident({{0, 0, 0}, {0, 0, 0}});
  coincident.update();
  EXPECT_EQ(coincident.bonds.size(), 0u);
}

TEST(Bonds, TheWeakerOfTwoMaterialsDecides) {
  Material weak = testMaterial();
  weak.stiffness = 2e4;
  weak.bond_rate = 0.1;
  weak.unbond_rate = 0.2;
  Bonded pair({{0, 0, 0}, {spacing, 0, 0}}, {testMaterial(), weak});
  pair.particles.material[1] = 1;
  EXPECT_FLOAT_EQ(pair.bonds.stiffness(0, 1), 2e4f * spacing);
  EXPECT_FLOAT_EQ(pair.bonds.stiffness(1, 0), 2e4f * spacing);
  EXPECT_FLOAT_EQ(pair.bonds.stiffness(0, 0), 1e5f * spacing);
  pair.particles.velocity[1].x() = 0.5f * spacing;  // above the weak one's rate, below the other's
  pair.update();
  EXPECT_EQ(pair.bonds.size(), 0u);
}

TEST(Bonds, AreListedAtBothEndsWithTheSameBitsInTheNeighboursOrder) {
  Bonded cloud(lattice(6, spacing, 0.15f));
  std::mt19937 random(3);
  for (int round = 0; round < 3; ++round) {
    cloud.particles.velocity =
        randomField(cloud.particles.size(), random, 0.004f * static_cast<float>(round));
    cloud.update();
    const VectorField step = randomField(cloud.particles.size(), random, 0.1f * spacing);
    for (std::size_t i = 0; i < step.size(); ++i) cloud.particles.position.add(i, step.at(i));
  }
  ASSERT_GT(cloud.bonds.size(), 300u);
  std::size_t listed = 0;
  for (std::uint32_t i = 0; i < cloud.particles.size(); ++i) {
    std::uint32_t p = cloud.near.begin(i);
    for (const Bond* b = cloud.bonds.begin(i); b != cloud.bonds.end(i); ++b, ++listed) {
      while (p < cloud.near.end(i) && cloud.near.other(p) != b->other) ++p;
      ASSERT_LT(p, cloud.near.end(i)) << "not in the neighbours' order";
      const Bond* back = cloud.find(b->other, i);
      ASSERT_NE(back, nullptr);
      EXPECT_EQ(std::memcmp(&b->rest_length, &back->rest_length, sizeof(float)), 0);
    }
  }
  EXPECT_EQ(listed, 2 * cloud.bonds.size());
}

TEST(Bonds, RigidRotationBreaksNone) {
  Bonded cloud(lattice(5, spacing, 0.1f));
  cloud.update();
  const std::size_t before = cloud.bonds.size();
  ASSERT_GT(before, 100u);
  const Eigen::Vector3f spin(30.0f, -80.0f, 50.0f);  // far above the unbonding rate
  for (std::size_t i = 0; i < cloud.particles.size(); ++i) {
    cloud.particles.velocity.set(i, spin.cross(cloud.particles.position.at(i)));
  }
  cloud.update();
  EXPECT_EQ(cloud.bonds.size(), before);
  for (std::size_t i = 0; i < cloud.particles.size(); ++i) {
    cloud.particles.velocity.set(i, 15.0f * cloud.particles.position.at(i));  // uniform stretch
  }
  cloud.update();
  EXPECT_EQ(cloud.bonds.size(), 0u);
}

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
TEST(Bonds, FlowBringsTheStressBackToYield) {
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

/// The strain of the volume is ln det F, within twice the square of the strain, and flow keeps it within a
/// hundredth.
TEST(Bonds, FlowKeepsTheStrainOfTheVolume) {
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
    const float told = 3.0f * cloud.bonds.flow().dilation[middle];
    EXPECT_LT(cloud.bonds.flow().share[middle], 0.7f);
    EXPECT_NEAR(told, volume, 2.0f * strain.squaredNorm());
    cloud.update(moment);
    EXPECT_NEAR(3.0f * cloud.bonds.flow().dilation[middle], told, 0.01f * std::abs(told));
  }
}

/// In simple shear by gamma a lattice has the stress E gamma, so it yields at gamma = 2 y.
TEST(Bonds, YieldStressIsTwiceStiffnessTimesYieldStrain) {
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

TEST(Bonds, WithoutYieldNothingFlows) {
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
