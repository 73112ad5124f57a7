#include "clay/forces/bonds.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>

#include "bonded.h"

namespace tactile_clay::clay::bonds_test {
namespace {

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

}  // namespace
}  // namespace tactile_clay::clay::bonds_test
