#include "clay/contact/contact_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "clouds.h"
#include "support/setups.h"

namespace tactile_clay::clay::contact_search_test {
namespace {

constexpr float spacing = 0.005f, dt = 1.0f / 240.0f, reach = Colliders::reach * spacing;
const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();

/// A search in one step, with what it looks at.
struct Search {
  Search(const std::vector<Eigen::Vector3f>& points, Skin skin, const std::vector<Solid>& solids = {})
      : particles(particlesAt(points, 2e-4f)), guess(zeros(points.size())), samples(std::move(skin)) {
    near.build(particles.position);
    std::vector<Eigen::Isometry3d> start, end;
    for (const Solid& s : solids) {
      start.push_back(s.pose);
      end.push_back(poseAfter(s, dt));
    }
    colliders.begin({samples, solids, start, end, dt});
  }
  const ContactSearch::Found& atStart(const std::vector<Contact>& before = {}) {
    return search.findAtStart(before, near, particles, guess, colliders, dt);
  }
  const ContactSearch::Found& strays(const VectorField& u) {
    return search.findStrays(particles, colliders, u, dt);
  }

  Particles particles;
  VectorField guess;
  Skin samples;
  Neighbourhood near{2.0f * spacing};
  Colliders colliders{spacing};
  ContactSearch search{spacing};
};

/// For each particle, the samples that pass within R of it in the step and did not start deep above it, found
/// one by one at a thousand times in the step. A particle less than half a spacing off the surface counts as
/// there, where its contact puts it.
std::map<std::uint32_t, std::set<std::uint32_t>> passingSamples(const Search& s) {
  std::map<std::uint32_t, std::set<std::uint32_t>> all;
  for (std::uint32_t i = 0; i < s.particles.size(); ++i) {
    for (std::uint32_t g = 0; g < s.samples.size(); ++g) {
      const Eigen::Vector3f motion = dt * s.samples.velocity[g], start = s.samples.position[g] - motion;
      const Eigen::Vector3f from = s.particles.position.at(i) - start, way = s.guess.at(i) - motion;
      if (s.samples.normal[g].dot(from) < -spacing) continue;
      Eigen::Vector3f nearest = from;
      for (int k = 0; k <= 1000; ++k) {
        const Eigen::Vector3f then = from + 0.001f * static_cast<float>(k) * way;
        if (then.norm() < nearest.norm()) nearest = then;
      }
      const float height = nearest.dot(s.samples.normal[g]);
      const float beside = (nearest - height * s.samples.normal[g]).norm();
      if (std::hypot(beside, std::max(std::abs(height), 0.5f * spacing)) < reach) all[i].insert(g);
    }
  }
  return all;
}

/// Skin that faces up and a cloud of clay, both in motion. Each contact has as its samples all that pass.
TEST(ContactSearch, FindsTheSamplesThatABruteForceSearchFinds) {
  std::mt19937 random(11);
  const std::vector<Eigen::Vector3f> points = lattice(8, spacing, 0.3f);
  Skin skin = samplePlane({0.0, 0.0, -0.015}, up, 0.03, 0.003);
  for (std::size_t g = 0; g < skin.size(); ++g) {
    skin.position[g] += randomVector(random, 0.003f);
    skin.velocity[g] = randomVector(random, 1.0f);
    skin.normal[g] = (Eigen::Vector3f::UnitZ() + randomVector(random, 0.2f)).normalized();
  }
  Search s(points, skin);
  s.guess = randomField(points.size(), random, spacing);
  const ContactSearch::Found& found = s.atStart();
  const auto passing = passingSamples(s);
  ASSERT_GT(found.contacts.size(), 100u);
  // At the border of R a thousand times and the search may differ.
  std::size_t differ = 0;
  std::uint32_t last = 0;
  for (const ContactGeometry& c : found.contacts) {
    EXPECT_EQ(c.solid, Contact::skin);
    EXPECT_GE(c.particle, last);  // in their order
    last = c.particle;
    std::set<std::uint32_t> samples;
    for (std::uint32_t k = 0; k < c.sample_count; ++k)
      samples.insert(found.shares[c.first_sample + k].sample);
    differ += samples != passing.at(c.particle);
  }
  EXPECT_LE(differ, found.contacts.size() / 100);
}

TEST(ContactSearch, TheGapIsWhatIsLackingToHalfASpacingOff) {
  const float height = 0.3f * spacing;
  Search s({{0.001f, 0.002f, height}}, samplePlane(Eigen::Vector3d::Zero(), up, 0.02, 0.004), {ground()});
  const ContactSearch::Found& found = s.atStart();
  ASSERT_EQ(found.contacts.size(), 2u);  // the skin first
  EXPECT_EQ(found.contacts[0].solid, Contact::skin);
  EXPECT_EQ(found.contacts[1].solid, 0u);
  for (const ContactGeometry& c : found.contacts)
    EXPECT_LT((c.normal - Eigen::Vector3f::UnitZ()).norm(), 1e-5f);
  // 0.2 spacings of penetration, 1 mm: the skin undoes them at 0.5 m/s within the step, the solid at 0.1 m/s.
  EXPECT_NEAR(found.contacts[0].gap, 0.2f * spacing, 1e-7f);
  EXPECT_NEAR(found.contacts[1].gap, 0.1f * dt, 1e-7f);
}

TEST(ContactSearch, ClayBetweenTwoFingersTouchesBoth) {
  Skin fingers = samplePlane({0.0, 0.0, -0.5 * spacing}, up, 0.02, 0.002);
  append(fingers, samplePlane({0.0, 0.0, 0.5 * spacing}, -up, 0.02, 0.002));
  Search s({{0.0f, 0.0f, 0.0f}}, fingers);
  const ContactSearch::Found& found = s.atStart();
  ASSERT_EQ(found.contacts.size(), 2u);
  EXPECT_LT(found.contacts[0].normal.dot(found.contacts[1].normal), -0.99f);
  EXPECT_EQ(found.contacts[0].sample_count + found.contacts[1].sample_count, found.shares.size());
}

/// A sheet of a tenth of a spacing; the particle starts five spacings over it and ends five under it.
TEST(ContactSearch, AThinSolidIsNotPassedBy) {
  Solid sheet;
  sheet.size = Eigen::Vector3d(0.1, 0.1, 0.05 * spacing);
  Search s({{0.0f, 0.0f, 5.0f * spacing}}, Skin(), {sheet});
  s.guess.set(0, {0.0f, 0.0f, -10.0f * spacing});
  const ContactSearch::Found& found = s.atStart();
  ASSERT_EQ(found.contacts.size(), 1u);
  EXPECT_GT(found.contacts[0].normal.z(), 0.99f);
  EXPECT_NEAR(found.contacts[0].gap, -(5.0f - 0.5f - 0.05f) * spacing, 1e-6f);
}

/// Deeper beneath the skin than the skin captures: only a particle that it held in the step before is pushed
/// out.
TEST(ContactSearch, FromTheDepthOnlyWhatWasHeldComesBack) {
  Search s({{0.0f, 0.0f, -1.2f * spacing}}, samplePlane(Eigen::Vector3d::Zero(), up, 0.02, 0.003));
  EXPECT_TRUE(s.atStart().contacts.empty());
  Contact held;
  held.particle = 0;
  held.solid = Contact::skin;
  held.state = Contact::State::slide;
  EXPECT_EQ(s.atStart({held}).contacts.size(), 1u);
  held.state = Contact::State::open;
  EXPECT_TRUE(s.atStart({held}).contacts.empty());
}

/// A particle meets nothing on the way of the guess, but the solution leads it into a wall or through the
/// skin.
TEST(ContactSearch, StraysAreFoundWhereTheyEnd) {
  Solid wall = ground();
  wall.pose.translation().z() -= 4.0 * spacing;
  const Skin skin = samplePlane({0.0, 0.0, 4.0 * spacing}, -up, 0.02, 0.003);
  Search s({{0.0f, 0.0f, 0.0f}}, skin, {wall});
  EXPECT_TRUE(s.atStart().contacts.empty());
  EXPECT_TRUE(s.strays(s.guess).contacts.empty());
  VectorField u = s.guess;
  u.set(0, {0.0f, 0.0f, -4.0f * spacing});
  const std::vector<ContactGeometry> below = s.strays(u).contacts;
  ASSERT_EQ(below.size(), 1u);
  EXPECT_EQ(below[0].solid, 0u);
  EXPECT_NEAR(below[0].gap, -3.5f * spacing, 1e-6f);  // along +z: it may go down so far
  u.set(0, {0.0f, 0.0f, 6.0f * spacing});             // through the skin, and beyond it
  const std::vector<ContactGeometry> above = s.strays(u).contacts;
  ASSERT_EQ(above.size(), 1u);
  EXPECT_EQ(above[0].solid, Contact::skin);
  EXPECT_LT(above[0].normal.z(), -0.99f);
  EXPECT_NEAR(above[0].gap, -3.5f * spacing, 1e-6f);
}

}  // namespace
}  // namespace tactile_clay::clay::contact_search_test
