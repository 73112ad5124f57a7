#include "clay/contact/contacts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <utility>

#include "clouds.h"
#include "support/setups.h"

namespace tactile_clay::clay {
namespace {

constexpr float spacing = 0.005f, dt = 1.0f / 240.0f, particle_mass = 2e-4f;
constexpr float inertia = particle_mass / (dt * dt);
const Eigen::Vector3f gravity(0.0f, 0.0f, -9.81f);

/// Particles that meet nothing but contacts. Their potential is solved to the end in each round, since
/// nothing couples one to the next.
struct Loose {
  Loose(const std::vector<Eigen::Vector3f>& points, float mu)
      : particles(particlesAt(points, particle_mass)),
        near(2.0f * spacing),
        contacts(spacing, {[mu] {
                   Material m;
                   m.friction = m.skin_friction = mu;
                   return m;
                 }()}),
        push(zeros(points.size())) {}

  void step(Skin skin, const std::vector<Solid>& solids, int rounds = 4) {
    samples = std::move(skin);
    const std::size_t n = particles.size();
    free = zeros(n);
    for (std::size_t i = 0; i < n; ++i) {
      free.set(i, dt * particles.velocity.at(i) + dt * dt / particle_mass * push.at(i));
    }
    std::vector<Eigen::Isometry3d> start, end;
    for (const Solid& s : solids) {
      start.push_back(s.pose);
      end.push_back(poseAfter(s, dt));
    }
    near.build(particles.position);
    contacts.detect(near, particles, free, {samples, solids, start, end, dt});
    u = free;
    for (int k = 0; k < rounds; ++k) {
      contacts.prescribe(u);
      VectorField z = residual();
      contacts.filter(0, z.size(), z);
      VectorField change = zeros(n);  // of friction, for a unit displacement along z
      contacts.addFrictionChange(z, 0, z.size(), change);
      for (std::size_t i = 0; i < n; ++i) {
        const float zz = z.at(i).squaredNorm();
        if (zz > 0.0f) u.add(i, zz / (inertia * zz - change.at(i).dot(z.at(i))) * z.at(i));
      }
      contacts.update(particles, u, residual());
    }
    contacts.expel(particles, u, dt);
    contacts.release(particles, u, dt);
    contacts.finish(particles, dt);
    for (std::size_t i = 0; i < n; ++i) {
      particles.position.add(i, u.at(i));
      particles.velocity.set(i, u.at(i) / dt);
    }
  }

  VectorField residual() const {
    VectorField r = zeros(particles.size());
    contacts.addFriction(u, 0, u.size(), r);
    for (std::size_t i = 0; i < r.size(); ++i) r.add(i, inertia * (free.at(i) - u.at(i)));
    return r;
  }

  Particles particles;
  Neighbourhood near;
  Skin samples;
  Contacts contacts;
  VectorField push;  // N, on each particle, gravity included
  VectorField free, u;
};

/// Normal and tangential part of a contact's force.
std::pair<float, float> parts(const Contact& c) {
  const float normal = c.force.dot(c.normal);
  return {normal, (c.force - normal * c.normal).norm()};
}

Skin floorOfSamples(const Eigen::Vector3d& velocity = Eigen::Vector3d::Zero()) {
  return samplePlane(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 0.02, 0.004, velocity);
}

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

/// As between two fingers that leave a particle no room. A particle that was never held stays (AreOneSided).
TEST(Contacts, WhatTheSkinHeldIsPushedOutFromAnyDepthWithinReach) {
  Loose pressed({{0.0f, 0.0f, 0.5f * spacing}}, 0.0f);
  pressed.push.set(0, particle_mass * gravity);
  pressed.step(floorOfSamples(), {});
  ASSERT_NE(pressed.contacts.contacts().at(0).state, Contact::State::open);
  pressed.particles.position.set(0, {0.0f, 0.0f, -1.2f * spacing});
  pressed.particles.velocity.set(0, Eigen::Vector3f::Zero());
  for (int k = 0; k < 10; ++k) pressed.step(floorOfSamples(), {});
  EXPECT_GE(pressed.particles.position[0].z(), 0.5f * spacing - 1e-6f);
}

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

/// Two palms, tilted to either side of the x axis, close on the origin by a spacing in a step, to where they
/// overlap.
struct ClosingPalms {
  explicit ClosingPalms(double tilt)
      : right(std::cos(tilt), 0.0, std::sin(tilt)), left(std::cos(tilt), 0.0, -std::sin(tilt)) {
    const Eigen::Vector3d closing = 1.0 * spacing / dt * Eigen::Vector3d::UnitZ();
    samples = samplePlane(0.3 * spacing * right, right, 0.02, 0.004, closing);
    append(samples, samplePlane(0.3 * spacing * left, left, 0.02, 0.004, -closing));
  }
  Eigen::Vector3d right, left;  // their normals
  Skin samples;
};

/// Two palms at 60 degrees close on a particle. It cannot be let out by one palm, nor by one after the other.
/// The nearest free place is 1.6 spacings away.
TEST(Contacts, WhatHandsSqueezeLeavesBetweenThem) {
  const ClosingPalms palms(M_PI / 3.0);
  Loose squeezed({{0.0f, 0.0f, 0.0f}}, 0.0f);
  squeezed.step(palms.samples, {}, 0);
  ASSERT_EQ(squeezed.contacts.contacts().size(), 2u);
  const Eigen::Vector3d end = squeezed.particles.position.at(0).cast<double>();
  for (const Eigen::Vector3d& n : {palms.right, palms.left})
    EXPECT_NEAR(n.dot(end), 0.8 * spacing, 0.01 * spacing);
}

/// The planes of two palms that all but face each other meet far from where they overlap.
TEST(Contacts, WhatPalmsOverlapIsNotPrescribedToWhereTheirPlanesMeet) {
  const ClosingPalms palms(80.0 * M_PI / 180.0);
  Loose squeezed({{0.0f, 0.0f, 0.0f}}, 0.0f);
  squeezed.step(palms.samples, {}, 0);
  ASSERT_EQ(squeezed.contacts.contacts().size(), 2u);
  VectorField u = zeros(1);
  squeezed.contacts.prescribe(u);
  EXPECT_GT(u.at(0).norm(), 0.5f * spacing);
  EXPECT_LT(u.at(0).norm(), 2.0f * spacing);
}

/// Out of a finger's end that is half in a palm, the nearest skin is deep in the palm's flesh.
TEST(Colliders, PlacesInFleshAreNotFree) {
  const double radius = 1.6 * spacing;
  Skin skin = samplePlane(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 0.03, 0.004);
  append(skin, sampleBall(Eigen::Vector3d::Zero(), radius, 0.6 * spacing));
  Colliders colliders(spacing);
  const std::vector<Solid> none;
  const std::vector<Eigen::Isometry3d> no_poses;
  colliders.begin({skin, none, no_poses, no_poses, dt});
  const Eigen::Vector3f x(0.0f, 0.0f, -0.9f * spacing);
  std::int64_t looks = 1'000'000;
  const auto place = colliders.nearestFree(x, 0.25f * spacing, 6.0f * spacing, looks);
  ASSERT_TRUE(place.has_value());
  EXPECT_GE(place->z(), 0.2f * spacing);
  EXPECT_GE(place->norm(), radius + 0.2 * spacing);
  EXPECT_LT((*place - x).norm(), 3.0f * spacing);
  EXPECT_FALSE(colliders.nearestFree(x, 0.25f * spacing, 1.5f * spacing, looks).has_value());
}

/// A finger's end comes down on a particle on the table until there is no room for it. The particle goes
/// aside, into neither of the two, by no more than it must, and the finger feels the force that moves it.
TEST(Contacts, WhatAFingerPressesOnTheTableGoesAside) {
  const double radius = 1.6 * spacing, gap = 0.2 * spacing, down = 0.8 * spacing / dt;
  const Skin tip = sampleBall({0.001, 0.0005, radius + gap}, radius, 0.6 * spacing, {0.0, 0.0, -down});
  Loose pressed({{0.0f, 0.0f, 0.5f * spacing}}, 0.0f);
  pressed.step(tip, {ground()});
  const Eigen::Vector3d end = pressed.particles.position.at(0).cast<double>();
  EXPECT_GE(end.z(), 0.499 * spacing);
  EXPECT_GE((end - Eigen::Vector3d(0.001, 0.0005, radius + gap)).norm(), radius + 0.4 * spacing);
  EXPECT_LT(end.head<2>().norm(), 2.5 * spacing);
  Eigen::Vector3f force = Eigen::Vector3f::Zero();
  for (const Contact& c : pressed.contacts.contacts()) force += c.force;
  EXPECT_NEAR((force - inertia * pressed.u.at(0)).norm(), 0.0f, 1e-3f * force.norm());
}

TEST(Contacts, WhatIsStoppedGoesIntoNoCollider) {
  Loose resting({{0.0f, 0.0f, 0.6f * spacing}}, 0.0f);
  resting.step(floorOfSamples(), {});
  ASSERT_EQ(resting.contacts.contacts().size(), 1u);
  const float room = 0.6f * spacing + resting.u.at(0).z() - 0.5f * spacing;
  ASSERT_GT(room, 0.0f);
  for (const float down : {-0.5f * room, 0.5f * room, 3.0f * room}) {
    VectorField w = zeros(1);
    w.set(0, {1e-4f, 0.0f, -down});
    resting.contacts.stop(resting.particles, resting.u, w);
    EXPECT_NEAR(w.at(0).x(), 1e-4f, 1e-9f);
    EXPECT_NEAR(w.at(0).z(), -std::min(down, room), 1e-3f * room);
  }
}

/// A particle that recovery moves past the contacts of the step does not end in skin either.
TEST(Contacts, WhatIsStoppedEndsInNoFlesh) {
  Loose resting({{0.0f, 0.0f, 0.6f * spacing}}, 0.0f);
  Skin skin = samplePlane({-1.1 * spacing, 0.0, 0.0}, Eigen::Vector3d::UnitX(), 0.01, 0.004);
  resting.step(skin, {ground()});
  for (const Contact& c : resting.contacts.contacts()) ASSERT_NE(c.solid, Contact::skin);
  for (const float way : {0.5f, 1.0f, 1.2f, 1.8f}) {
    VectorField w = zeros(1);
    w.set(0, {-way * spacing, 0.0f, 0.0f});
    resting.contacts.stop(resting.particles, resting.u, w);
    EXPECT_EQ(w.at(0).x(), way < 1.1f ? -way * spacing : 0.0f) << way;
  }
  // It is stopped even on a short way if the step led it to skin that it had not met.
  VectorField u = zeros(1), w = zeros(1);
  u.set(0, {-1.0f * spacing, 0.0f, 0.0f});
  w.set(0, {-0.15f * spacing, 0.0f, 0.0f});
  resting.contacts.stop(resting.particles, u, w);
  EXPECT_EQ(w.at(0).x(), 0.0f);
}

/// Nor does it end under the table, which it did not reach in the step.
TEST(Contacts, WhatIsStoppedEndsInNoSolid) {
  const float height = 2.2f * spacing;
  Loose above({{0.0f, 0.0f, height}}, 0.0f);
  above.step({}, {ground()});
  ASSERT_TRUE(above.contacts.contacts().empty());
  for (const float way : {0.2f, 2.1f, 2.3f}) {
    VectorField w = zeros(1);
    w.set(0, {0.0f, 0.0f, -way * spacing});
    above.contacts.stop(above.particles, zeros(1), w);
    EXPECT_EQ(w.at(0).z(), way * spacing < height ? -way * spacing : 0.0f) << way;
  }
}

/// A sample of one finger, and some of another which faces nearly as the first does, but is farther: their
/// mean, which is the contact's plane, is behind the first one's skin.
struct MeetingFingers {
  MeetingFingers() {
    const Eigen::Vector3f slant(std::cos(1.2f), std::sin(1.2f), 0.0f);
    samples.position.push_back(Eigen::Vector3f::Zero());
    samples.normal.push_back(Eigen::Vector3f::UnitX());
    for (const float z : {-0.5f, -0.2f, 0.2f, 0.5f}) {
      samples.position.push_back(spacing * (Eigen::Vector3f(0.0f, 0.0f, z) - 0.9f * slant));
      samples.normal.push_back(slant);
    }
    samples.velocity.assign(samples.position.size(), Eigen::Vector3f::Zero());
  }
  Skin samples;
};

TEST(Contacts, WhatIsStoppedEndsInNoSkinBeforeTheMean) {
  const MeetingFingers fingers;
  Loose between({{0.2f * spacing, 0.0f, 0.0f}}, 0.0f);
  between.step(fingers.samples, {});
  ASSERT_EQ(between.contacts.contacts().size(), 1u);
  ASSERT_EQ(between.u.at(0).norm(), 0.0f);  // the plane leaves it free
  for (const float way : {0.05f, 0.15f, 0.22f}) {
    VectorField w = zeros(1);
    w.set(0, {-way * spacing, 0.0f, 0.0f});
    between.contacts.stop(between.particles, between.u, w);
    EXPECT_EQ(w.at(0).x(), way < 0.1f ? -way * spacing : 0.0f) << way;
  }
}

TEST(Contacts, WhatIsBeneathSkinBeforeTheMeanIsLedOut) {
  const MeetingFingers fingers;
  Loose pushed({{0.1f * spacing, 0.0f, 0.0f}}, 0.0f);
  pushed.push.set(0, {-0.2f * spacing * inertia, 0.0f, 0.0f});
  pushed.step(fingers.samples, {});
  EXPECT_GT(pushed.particles.position[0].x(), 0.05f * spacing);
}

/// The planes of skin that squeezed a particle are not valid for ways from the place where it was released.
TEST(Contacts, WhatWasReleasedStays) {
  const ClosingPalms palms(M_PI / 3.0);
  Loose squeezed({{0.0f, 0.0f, 0.0f}}, 0.0f);
  squeezed.step(palms.samples, {}, 0);
  VectorField w = zeros(1);
  w.set(0, {0.0f, 0.2f * spacing, 0.0f});
  squeezed.contacts.stop(squeezed.particles, squeezed.u, w);
  EXPECT_EQ(w.at(0).norm(), 0.0f);
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
}  // namespace tactile_clay::clay
