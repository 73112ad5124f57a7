#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "clay/contact/contacts.h"
#include "loose.h"

/// Skin and solids that leave a particle no room: where it goes, and where it stops.
namespace tactile_clay::clay::contacts_room_test {
namespace {

using namespace loose;

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

}  // namespace
}  // namespace tactile_clay::clay::contacts_room_test
