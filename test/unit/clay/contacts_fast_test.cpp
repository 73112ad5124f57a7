#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "clay/contact/contacts.h"
#include "loose.h"

/// Fast particles, fast skin and fast solids meet where they touch first, and pass through nothing.
namespace tactile_clay::clay::contacts_fast_test {
namespace {

using namespace loose;

/// A particle meets skin on its way that was out of its reach, and ends 1.3 spacings deep in it.
TEST(Contacts, WhatEndsDeepInTheSkinAndBeganBeforeItIsMetThere) {
  Loose struck({{0.0f, 0.0f, 1.1f * spacing}}, 0.0f);
  const Skin skin = floorOfSamples();
  struck.step(skin, {});
  ASSERT_TRUE(struck.contacts.contacts().empty());
  struck.u.set(0, {0.0f, 0.0f, -2.4f * spacing});
  ASSERT_TRUE(struck.contacts.detectStrays(struck.particles, struck.u, dt));
  struck.contacts.expel(struck.particles, struck.u, dt);
  EXPECT_NEAR((struck.particles.position.at(0) + struck.u.at(0)).z(), 0.5f * spacing, 1e-6f);
}

/// A particle goes through the skin and out of its reach, as into the middle of a finger.
TEST(Contacts, WhatWentThroughTheSkinIsMetWhereItDid) {
  Loose struck({{0.0f, 0.0f, 2.0f * spacing}}, 0.0f);
  const Skin skin = floorOfSamples();
  struck.step(skin, {});
  ASSERT_TRUE(struck.contacts.contacts().empty());
  struck.u.set(0, {0.2f * spacing, 0.0f, -4.0f * spacing});
  ASSERT_TRUE(struck.contacts.detectStrays(struck.particles, struck.u, dt));
  struck.contacts.expel(struck.particles, struck.u, dt);
  EXPECT_NEAR((struck.particles.position.at(0) + struck.u.at(0)).z(), 0.5f * spacing, 1e-6f);
}

/// A particle flies more than half through a slab, and so ends nearer to its other side.
TEST(Contacts, WhatFliesDeepIntoASolidIsMetWhereItCameIn) {
  Loose flying({{0.0f, 0.0f, 1.5f * spacing}}, 0.0f);
  flying.step({}, {ground()});
  ASSERT_TRUE(flying.contacts.contacts().empty());
  const auto thickness = static_cast<float>(2.0 * ground().size.z());
  flying.u.set(0, {0.0f, 0.0f, -0.75f * thickness});
  ASSERT_TRUE(flying.contacts.detectStrays(flying.particles, flying.u, dt));
  flying.contacts.expel(flying.particles, flying.u, dt);
  EXPECT_NEAR((flying.particles.position.at(0) + flying.u.at(0)).z(), 0.5f * spacing, 1e-3f * spacing);
}

/// 21 mm per step, onto samples that are 1 spacing thick to either side.
TEST(Contacts, FastParticlesDoNotPassThroughSkin) {
  Loose loose({{0.0f, 0.0f, 0.01f}}, 0.0f);
  loose.particles.velocity.set(0, {0.0f, 0.0f, -5.0f});
  for (int k = 0; k < 5; ++k) loose.step(floorOfSamples(), {});
  EXPECT_GE(loose.particles.position[0].z(), 0.5f * spacing - 1e-6f);
}

TEST(Contacts, FastParticlesDoNotPassThroughThickSolids) {
  Loose loose({{0.0f, 0.0f, 0.01f}}, 0.0f);
  loose.particles.velocity.set(0, {0.0f, 0.0f, -5.0f});
  for (int k = 0; k < 5; ++k) loose.step({}, {ground()});
  EXPECT_GE(loose.particles.position[0].z(), 0.5f * spacing - 1e-6f);
}

TEST(Contacts, FastParticlesDoNotPassThroughThinSolids) {
  Solid plate;
  plate.size = {0.05, 0.05, 0.0005};
  Loose loose({{0.0f, 0.0f, 0.01f}}, 0.0f);
  loose.particles.velocity.set(0, {0.0f, 0.0f, -5.0f});
  for (int k = 0; k < 5; ++k) loose.step({}, {plate});
  EXPECT_GE(loose.particles.position[0].z(), 0.5f * spacing - 1e-6f);
}

/// In a wedge, one wall pushes into the other.
TEST(Contacts, WhatFellThroughAWedgeIsExpelledFromBothWalls) {
  const std::vector<Solid> wedge{ground(0.9), ground(-0.9)};
  Loose loose({{0.0f, 0.001f, 1.5f * spacing}}, 0.0f);
  loose.particles.velocity.set(0, {0.0f, 0.0f, -0.05f / dt});
  loose.step({}, wedge, 0);
  for (const Solid& wall : wedge) {
    const Eigen::Vector3d out = wall.pose.linear().col(2);
    EXPECT_GE(out.dot(loose.particles.position.at(0).cast<double>()), 0.499 * spacing);
  }
}

/// Solids of every shape, thrown and spun at random past particles at rest: each particle in which a step
/// ends is met.
TEST(Contacts, WhatMovesIntoAParticleIsMetFromAfar) {
  std::mt19937 random(11);
  std::size_t met = 0, from_afar = 0;
  for (int k = 0; k < 300; ++k) {
    Solid solid;
    solid.shape = std::array{Solid::Shape::box, Solid::Shape::cylinder, Solid::Shape::sphere}[k % 3];
    solid.size =
        Eigen::Vector3d(0.002, 0.002, 0.002) + 0.06 * randomVector(random, 1.0f).cast<double>().cwiseAbs();
    solid.pose = Eigen::Translation3d(0.1 * randomVector(random, 1.0f).cast<double>()) *
                 Eigen::AngleAxisd(3.0 * k, randomVector(random, 1.0f).cast<double>().normalized());
    solid.linear_velocity = 20.0 * randomVector(random, 1.0f).cast<double>();
    solid.angular_velocity = 200.0 * randomVector(random, 1.0f).cast<double>();
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 1000; ++i) points.push_back(randomVector(random, 0.2f));
    Loose loose(points, 0.0f);
    loose.step({}, {solid}, 0);
    const Eigen::Isometry3d to_end = poseAfter(solid, dt).inverse(), to_start = solid.pose.inverse();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double before = surface(solid, to_start * points[i].cast<double>()).distance;
      if (before < 0.0 || surface(solid, to_end * points[i].cast<double>()).distance > 0.0) continue;
      const auto& contacts = loose.contacts.contacts();
      EXPECT_TRUE(
          std::any_of(contacts.begin(), contacts.end(), [&](const Contact& c) { return c.particle == i; }))
          << "solid " << k << " particle " << i;
      ++met;
      if (before > 0.05) ++from_afar;
    }
  }
  EXPECT_GT(met, 1000u);
  EXPECT_GT(from_afar, 100u);
}

}  // namespace
}  // namespace tactile_clay::clay::contacts_fast_test
