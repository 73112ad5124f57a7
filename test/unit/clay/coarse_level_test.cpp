#include "clay/solver/coarse_level.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <tuple>

#include "clay/forces/potential.h"
#include "clouds.h"
#include "support/setups.h"
#include "support/vectors.h"

namespace tactile_clay::clay::coarse_level_test {
namespace {

constexpr float spacing = 0.005f, dt = 1.0f / 240.0f, particle_mass = 2e-4f;
constexpr int edge = 10;
constexpr std::size_t block = edge * edge * edge;

Material clayOf(double bulk_modulus) {
  Material m;
  m.bulk_modulus = bulk_modulus;
  m.viscosity = 100.0;
  m.stiffness = 1e5;
  return m;
}

/// A block of clay that stands on a floor, and a crumb beside it. Nothing is compressed, so that a change of
/// force is that of the springs.
struct Clays {
  explicit Clays(double bulk_modulus = 0.0) : material(clayOf(bulk_modulus)) {
    std::vector<Eigen::Vector3f> points;
    for (const Eigen::Vector3f& p : lattice(edge, 1.05f * spacing, 0.05f)) points.push_back(p);
    for (const Eigen::Vector3f& p : lattice(4, 1.05f * spacing, 0.05f))
      points.push_back(p + Eigen::Vector3f(0.2f, 0.0f, 0.0f));
    particles = particlesAt(points, particle_mass);
    guess = zeros(points.size());
    near.build(particles.position);
    bonds.update(near, particles, particles.velocity, true);
    touchFloor();
    potential.linearise(input, contacts.contacts(), step);
    at.resize(points.size());
    inertia.assign(points.size(), particle_mass / (dt * dt));
    std::mt19937 random(5);
    r = randomField(points.size(), random, 0.01f);
  }
  /// Closes the contacts of the lowest layer with a floor.
  void touchFloor() {
    Solid floor = ground();
    floor.pose.translation().z() -= 0.5 * static_cast<double>(edge * 1.05f * spacing);
    const std::vector<Eigen::Isometry3d> poses{floor.pose};
    contacts.detect(near, particles, guess, {skin, {floor}, poses, poses, dt});
    std::vector<Contact> closed = contacts.contacts();
    for (Contact& c : closed) c.state = Contact::State::slide;
    contacts.restore(closed);
  }
  CoarseLevel::Step coarse() const { return {input, step.pairs, contacts, inertia}; }
  Vectors product(const VectorField& w) {
    VectorField change = zeros(w.size()), u = change;
    step.startForce(u, change, at).add(0, w.size());
    step.startChange(w, change, at).add(0, w.size());
    Vectors a_w = toVectors(change);
    for (std::size_t i = 0; i < a_w.size(); ++i)
      a_w[i] = static_cast<double>(inertia[i]) * w.at(i).cast<double>() - a_w[i];
    return a_w;
  }

  Material material;
  Particles particles;
  VectorField guess, r;
  Neighbourhood near{2.0f * spacing};
  Bonds bonds{spacing, {material}};
  Potential potential{Kernel(2.0f * spacing), spacing, {material}};
  StepPotential step;
  Compression at;
  Skin skin;
  Contacts contacts{spacing, {material}};
  std::vector<float> inertia;
  StepInput input{near, particles, &bonds, guess, dt};
};

/// The residual that is left has no part along the motion of any cube: W^T (r - A w) = 0. A cube is known by
/// the displacement of its particles.
void expectSolved(Clays& clays) {
  CoarseLevel level(spacing);
  ASSERT_TRUE(level.acts(clays.coarse()));
  VectorField w = zeros(clays.particles.size());
  level.solve(clays.r, w);
  const Vectors a_w = clays.product(w);
  struct Left {
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    double size = 0.0;
    int particles = 0;
  };
  std::map<std::tuple<float, float, float>, Left> cubes;
  for (std::size_t i = 0; i < block; ++i) {
    const Eigen::Vector3f motion = w.at(i);
    if (motion.isZero(0.0f)) continue;
    Left& left = cubes[{motion.x(), motion.y(), motion.z()}];
    left.force += clays.r.at(i).cast<double>() - a_w[i];
    left.size += a_w[i].norm();
    ++left.particles;
  }
  EXPECT_EQ(cubes.size(), 64u);  // 10 spacings of 1.05 are more than three widths of 3
  int inside = 0;
  for (const auto& [motion, left] : cubes) {
    EXPECT_LT(left.force.norm(), 1e-3 * left.size) << left.particles;
    inside += left.particles;
  }
  EXPECT_EQ(inside, block - edge * edge);  // but those that the floor holds
}

TEST(CoarseLevel, LeavesNoResidualAlongTheMotionOfAnyCube) {
  for (const double bulk_modulus : {0.0, 1e6}) {
    Clays clays(bulk_modulus);
    expectSolved(clays);
  }
}

TEST(CoarseLevel, DoesNotMoveWhatContactsHoldNorCrumbs) {
  Clays clays;
  CoarseLevel level(spacing);
  ASSERT_TRUE(level.acts(clays.coarse()));
  VectorField w = zeros(clays.particles.size());
  level.solve(clays.r, w);
  ASSERT_EQ(clays.contacts.contacts().size(), static_cast<std::size_t>(edge * edge));
  for (const Contact& c : clays.contacts.contacts()) EXPECT_TRUE(w.at(c.particle).isZero(0.0f));
  for (std::size_t i = block; i < w.size(); ++i) EXPECT_TRUE(w.at(i).isZero(0.0f));
}

TEST(CoarseLevel, ActsOnStiffLumpsOnly) {
  Clays clays;
  const auto acts = [&](const StepInput& in, const PairArrays& pairs) {
    CoarseLevel level(spacing);
    return level.acts({in, pairs, clays.contacts, clays.inertia});
  };
  EXPECT_TRUE(acts(clays.input, clays.step.pairs));
  PairArrays loose = clays.step.pairs;
  loose.sprung = false;
  EXPECT_FALSE(acts(clays.input, loose));
  const std::vector<float> inertia = clays.inertia;
  clays.inertia.assign(inertia.size(), 1000.0f * inertia[0]);
  EXPECT_FALSE(acts(clays.input, clays.step.pairs));
  clays.inertia = inertia;
  const Particles crumb = particlesAt(lattice(4, spacing, 0.0f), particle_mass);
  clays.near.build(crumb.position);
  const Contacts none(spacing, {clays.material});
  CoarseLevel level(spacing);
  const StepInput alone{clays.near, crumb, nullptr, clays.guess, dt};
  EXPECT_FALSE(level.acts({alone, clays.step.pairs, none, clays.inertia}));
}

/// Matrices of a fresh step serve for the steps that follow.
TEST(CoarseLevel, KeepsItsMatricesUntilTheClayIsFresh) {
  Clays clays;
  CoarseLevel level(spacing);
  ASSERT_TRUE(level.acts(clays.coarse()));
  VectorField before = zeros(clays.particles.size()), kept = before, fresh = before;
  level.solve(clays.r, before);
  clays.inertia.assign(clays.inertia.size(), 4.0f * clays.inertia[0]);
  clays.input.fresh = false;
  level.begin(clays.input);
  ASSERT_TRUE(level.acts(clays.coarse()));
  level.solve(clays.r, kept);
  clays.input.fresh = true;
  level.begin(clays.input);
  ASSERT_TRUE(level.acts(clays.coarse()));
  level.solve(clays.r, fresh);
  float difference = 0.0f;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(kept.at(i), before.at(i));
    difference = std::max(difference, (fresh.at(i) - before.at(i)).norm() / (1e-9f + before.at(i).norm()));
  }
  EXPECT_GT(difference, 0.05f);
}

}  // namespace
}  // namespace tactile_clay::clay::coarse_level_test
