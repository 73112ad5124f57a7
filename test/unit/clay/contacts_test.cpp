#include "clay/contact/contacts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "loose.h"

/// Forces of contacts: they push and never pull, and obey Coulomb's law of friction.
namespace tactile_clay::clay::contacts_test {
namespace {

using namespace loose;

TEST(Contacts, AParticleAtRestIsHeldHalfASpacingOffAndWeighs) {
  for (const bool skin : {false, true}) {
    Loose loose({{0.001f, 0.002f, 0.5f * spacing}}, 0.5f);
    loose.push.set(0, particle_mass * gravity);
    for (int k = 0; k < 20; ++k) {
      loose.step(skin ? floorOfSamples() : Skin(),
                 skin ? std::vector<Solid>() : std::vector<Solid>{ground()});
    }
    ASSERT_EQ(loose.contacts.contacts().size(), 1u);
    const auto [normal, tangential] = parts(loose.contacts.contacts()[0]);
    EXPECT_NEAR(normal, particle_mass * 9.81f, 1e-4f * particle_mass * 9.81f);
    EXPECT_LT(tangential, 1e-4f * normal);
    EXPECT_NEAR(loose.particles.position[0].z(), 0.5f * spacing, 1e-7f);
  }
}

TEST(Contacts, PushNeverPull) {
  // leaving the surface, or the surface leaving: no force
  for (const bool skin : {false, true}) {
    Loose loose({{0.0f, 0.0f, 0.5f * spacing}}, 0.5f);
    loose.push.set(0, {0.0f, 0.0f, 0.01f});
    loose.step(skin ? floorOfSamples() : Skin(), skin ? std::vector<Solid>() : std::vector<Solid>{ground()});
    for (const Contact& c : loose.contacts.contacts()) EXPECT_EQ(c.force.norm(), 0.0f);
    EXPECT_FLOAT_EQ(loose.particles.velocity[0].z(), 0.01f / particle_mass * dt);
  }
  Loose left({{0.0f, 0.0f, 0.5f * spacing}}, 0.5f);
  left.step(floorOfSamples({0.0, 0.0, -0.1}), {});
  EXPECT_LT(left.particles.velocity.at(0).norm(), 1e-6f);  // rounding of the gap
}

TEST(Contacts, AreOneSided) {
  // deeper behind the skin than a spacing: that is another body's clay, not a penetration
  Loose behind({{0.0f, 0.0f, -1.2f * spacing}}, 0.5f);
  behind.step(floorOfSamples(), {});
  EXPECT_TRUE(behind.contacts.contacts().empty());
  // a little behind it: out, along the normal
  Loose inside({{0.0f, 0.0f, -0.5f * spacing}}, 0.0f);
  for (int k = 0; k < 10; ++k) inside.step(floorOfSamples(), {});
  EXPECT_GE(inside.particles.position[0].z(), 0.5f * spacing - 1e-6f);
}

TEST(Contacts, OppositeSkinsAreTwoContacts) {
  Skin fingers = samplePlane({0, 0, -0.5 * spacing}, Eigen::Vector3d::UnitZ(), 0.01, 0.004);
  append(fingers, samplePlane({0, 0, 0.5 * spacing}, -Eigen::Vector3d::UnitZ(), 0.01, 0.004));
  Loose held({{0.0f, 0.0f, 0.0f}}, 0.8f);
  held.step(fingers, {});
  ASSERT_EQ(held.contacts.contacts().size(), 2u);
  EXPECT_LT(held.contacts.contacts()[0].normal.dot(held.contacts.contacts()[1].normal), -0.99f);
}

TEST(Contacts, SharesAddUpToOneAndAreTheSamplesInReach) {
  Loose loose(lattice(3, spacing, 0.2f), 0.5f);
  for (std::size_t i = 0; i < loose.particles.size(); ++i) loose.particles.position[i].z() += 0.008f;
  const Skin samples = floorOfSamples();
  loose.step(samples, {});
  ASSERT_FALSE(loose.contacts.contacts().empty());
  for (const Contact& c : loose.contacts.contacts()) {
    float total = 0.0f;
    for (std::uint32_t s = c.first_sample; s < c.first_sample + c.sample_count; ++s) {
      const SampleShare& share = loose.contacts.shares()[s];
      total += share.share;
      EXPECT_GT(share.share, 0.0f);
      const Eigen::Vector3f before = loose.particles.position.at(c.particle) - loose.u.at(c.particle);
      EXPECT_LE((samples.position[share.sample] - before).norm(),
                1.5f * spacing + loose.free.at(c.particle).norm());
    }
    EXPECT_NEAR(total, 1.0f, 1e-6f);
  }
}

/// Many particles, pushed at random: all contact forces are in the cone, those of particles at rest inside
/// it, and those of sliding particles on it and against the slip. Momentum changes by exactly the forces.
TEST(Contacts, ForcesStayInTheCoulombCone) {
  constexpr float mu = 0.4f;
  std::mt19937 random(5);
  for (const bool skin : {false, true}) {
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 40; ++i) {
      points.emplace_back(0.02f * static_cast<float>(i % 8 - 4), 0.02f * static_cast<float>(i / 8 - 2),
                          0.5f * spacing);
    }
    Skin samples;
    if (skin) samples = samplePlane(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 0.1, 0.004);
    const std::vector<Solid> solids = skin ? std::vector<Solid>() : std::vector<Solid>{ground()};
    Loose loose(points, mu);
    std::size_t slid = 0, stuck = 0;
    for (int k = 0; k < 60; ++k) {
      if (k % 20 == 0) {
        for (std::size_t i = 0; i < points.size(); ++i) {
          loose.push.set(
              i, particle_mass * (gravity + Eigen::Vector3f(randomVector(random, 8.0f).x(), 0.0f, 0.0f)));
        }
      }
      const VectorField before = loose.particles.velocity;
      loose.step(samples, solids);
      VectorField total = loose.push;
      for (const Contact& c : loose.contacts.contacts()) {
        const auto [normal, tangential] = parts(c);
        EXPECT_GE(normal, -1e-6f * particle_mass * 9.81f);
        EXPECT_LE(tangential, mu * normal * 1.001f + 1e-6f * particle_mass * 9.81f);
        slid += c.state == Contact::State::slide ? 1 : 0;
        stuck += c.state == Contact::State::stick ? 1 : 0;
        total.add(c.particle, c.force);
      }
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3f force = particle_mass / dt * (loose.particles.velocity.at(i) - before.at(i));
        EXPECT_LT((force - total.at(i)).norm(), 2e-3f * particle_mass * 9.81f)
            << "particle " << i << " step " << k;
      }
    }
    EXPECT_GT(slid, 100u);
    EXPECT_GT(stuck, 100u);
  }
}

/// A contact gives way by a hundredth of a spacing before it slides, under any load; twice that is allowed
/// for, since the stiffness follows the load.
TEST(Contacts, WhatSticksHardlyGivesWayHoweverHardItIsPressed) {
  constexpr float mu = 0.5f;
  for (const float load : {0.01f, 0.1f, 1.0f}) {  // N
    Loose loose({{0.0f, 0.0f, 0.5f * spacing}}, mu);
    loose.push.set(0, {0.0f, 0.0f, -load});
    for (int k = 0; k < 20; ++k) loose.step({}, {ground()});
    for (int k = 1; k <= 20; ++k) {
      loose.push.set(0, {0.04f * static_cast<float>(k) * mu * load, 0.0f, -load});
      loose.step({}, {ground()});
    }
    EXPECT_LT(loose.particles.position[0].x(), 0.02f * spacing) << load << " N";
    EXPECT_GT(loose.particles.position[0].x(), 0.0f) << load << " N";
  }
}

TEST(Contacts, AParticleRestsBelowTheFrictionAngleAndSlidesAbove) {
  constexpr double mu = 0.5, g = 9.81;
  for (const double degrees : {1.0, -1.0}) {
    const double slope = std::atan(mu) + degrees * M_PI / 180.0;
    const Solid incline = ground(slope);
    const Eigen::Vector3d out = incline.pose.linear() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d down = incline.pose.linear() * Eigen::Vector3d::UnitX();
    Loose loose({(0.5 * spacing * out).cast<float>()}, static_cast<float>(mu));
    loose.push.set(0, particle_mass * gravity);
    for (int k = 0; k < 240; ++k) loose.step({}, {incline});
    const double speed = down.dot(loose.particles.velocity.at(0).cast<double>());
    if (degrees < 0.0) {
      EXPECT_LT(std::abs(speed), 1e-4);
    } else {
      EXPECT_NEAR(speed, g * (std::sin(slope) - mu * std::cos(slope)), 0.05 * speed);  // after one second
    }
  }
}

/// Friction never turns a motion around: what it stops stays stopped.
TEST(Contacts, ASlidingParticleComesToRest) {
  for (const float speed : {0.02f, 0.1f, 0.5f}) {
    Loose loose({{0.0f, 0.0f, 0.5f * spacing}}, 0.5f);
    loose.particles.velocity[0].x() = speed;
    loose.push.set(0, particle_mass * gravity);
    for (int k = 0; k < 60; ++k) {
      const float before = loose.particles.velocity[0].x();
      loose.step({}, {ground()});
      EXPECT_LE(std::abs(loose.particles.velocity[0].x()), std::abs(before) + 1e-3f) << "step " << k;
    }
    EXPECT_LT(std::abs(loose.particles.velocity[0].x()), 1e-5f);
  }
}

/// A particle that slid and then turned round is not pushed by the friction of its slide.
TEST(Contacts, TheFrictionOfASlideDoesNotPush) {
  constexpr float back = 0.005f;
  Loose loose({{0.0f, 0.0f, 0.5f * spacing}}, 0.5f);
  loose.push.set(0, particle_mass * gravity);
  loose.particles.velocity[0].x() = 0.5f;
  for (int k = 0; k < 4; ++k) loose.step({}, {ground()});
  ASSERT_EQ(loose.contacts.contacts().at(0).state, Contact::State::slide);
  loose.particles.velocity[0].x() = -back;
  loose.step({}, {ground()}, 1);
  EXPECT_LE(std::abs(loose.particles.velocity[0].x()), back);
}

TEST(Contacts, AStickingParticleFollowsAMovingSurface) {
  Solid belt = ground();
  belt.linear_velocity = {0.1, 0.0, 0.0};
  Loose loose({{0.0f, 0.0f, 0.5f * spacing}}, 0.8f);
  loose.push.set(0, particle_mass * gravity);
  for (int k = 0; k < 60; ++k) {
    loose.step({}, {belt});
    belt.pose = poseAfter(belt, dt);
  }
  EXPECT_NEAR(loose.particles.velocity[0].x(), 0.1f, 1e-4f);
  EXPECT_NEAR(loose.particles.velocity[0].z(), 0.0f, 1e-6f);
}

/// A contact that prescribes the way to where it closes may have to pull for that.
TEST(Contacts, WorkOfPullingIsTold) {
  Loose loose({{0.0f, 0.001f, 0.6f * spacing}}, 0.0f);
  loose.particles.velocity.set(0, {0.0f, 0.0f, -0.15f * spacing / dt});
  loose.step({}, {ground()}, 0);  // for a contact, a tenth of a spacing away
  ASSERT_EQ(loose.contacts.contacts().size(), 1u);
  const float gap = loose.contacts.contacts()[0].gap;
  ASSERT_NEAR(gap, -0.1f * spacing, 1e-6f);
  for (const float push : {-0.02f, 0.01f}) {  // N
    VectorField u = zeros(1), residual = zeros(1);
    u.set(0, {0.0f, 0.0f, 2.0f * gap});
    loose.contacts.prescribe(u);
    EXPECT_FLOAT_EQ(u.at(0).z(), gap);
    residual.set(0, {0.0f, 0.0f, push});
    const Contacts::Changes changes = loose.contacts.update(loose.particles, u, residual);
    EXPECT_FLOAT_EQ(static_cast<float>(changes.pulled), push > 0.0f ? -push * gap : 0.0f);
  }
}

}  // namespace
}  // namespace tactile_clay::clay::contacts_test
