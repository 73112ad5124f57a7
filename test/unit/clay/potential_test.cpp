#include "clay/forces/potential.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>
#include <random>
#include <vector>

#include "potential_cloud.h"

/// Forces are gradients of their energies, and changes of force those of the forces.
namespace tactile_clay::clay::potential_test {
namespace {

using namespace potential_cloud;

/// The energies are quadratic in u, so that central differences are exact but for rounding.
template <typename Energy>
void expectForceIsGradient(const Cloud& s, const Vectors& force, Vectors u, const Energy& energy) {
  const double step = 1e-5, tolerance = 2e-4 * largest(force);
  ASSERT_GT(largest(force), 0.0);
  for (std::size_t i = 0; i < s.size(); i += 7) {
    for (int a = 0; a < 3; ++a) {
      const double at = u[i][a];
      u[i][a] = at + step;
      const double above = energy(u);
      u[i][a] = at - step;
      const double below = energy(u);
      u[i][a] = at;
      EXPECT_NEAR(force[i][a], -(above - below) / (2.0 * step), tolerance)
          << "particle " << i << " axis " << a;
    }
  }
}

TEST(Potential, DensityForceIsTheGradientOfItsEnergy) {
  for (const float scale : {0.93f, 0.6f}) {
    Cloud s(density_only, scale);
    const auto ratios = std::minmax_element(s.densityRatio().begin(), s.densityRatio().end());
    ASSERT_LT(*ratios.first, 1.5f);
    ASSERT_EQ(*ratios.second > 3.0f, scale < 0.9f);
    const VectorField u = smallMotion(s);
    const Vectors at = toVectors(u);
    expectForceIsGradient(s, s.forceAt(u), at, [&](const Vectors& v) { return s.densityEnergy(v, at); });
  }
}

TEST(Potential, ViscousForceIsTheGradientOfItsEnergy) {
  for (const float angle : {0.0f, 0.4f}) {
    const Eigen::Matrix3f turn =
        Eigen::AngleAxisf(angle, Eigen::Vector3f(1, -2, 0.5f).normalized()).toRotationMatrix();
    Cloud s(viscosity_only, 1.0f, turn);
    const VectorField u = smallMotion(s);
    expectForceIsGradient(s, s.forceAt(u), toVectors(u),
                          [&](const Vectors& v) { return s.viscousEnergy(v); });
  }
}

TEST(Potential, BondForceIsTheGradientOfItsEnergy) {
  Cloud s(bonds_only);
  ASSERT_GT(s.bonds.size(), 300u);
  const VectorField u = smallMotion(s);
  expectForceIsGradient(s, s.forceAt(u), toVectors(u), [&](const Vectors& v) { return s.bondEnergy(v); });
}

/// A block of one material whose bonds yield in a shear of a few percent.
struct YieldingBlock {
  static constexpr int edge = 7;
  static constexpr std::uint32_t middle = edge * edge * edge / 2;
  static constexpr float shear = 0.03f;

  YieldingBlock() {
    material.yield_strain = 0.0025;
    material.unbond_rate = 1e9;
    bonds.emplace(spacing, std::vector<Material>{material});
    potential.emplace(Kernel(2.0f * spacing), spacing, std::vector<Material>{material});
    for (std::size_t i = 0; i < block.size(); ++i) sheared[i].x() = shear * block.position[i].y();
    update();
  }
  void update() {
    near.build(block.position);
    bonds->update(near, block, block.velocity, true);
  }
  StepInput input(const VectorField& guess) const { return {near, block, &*bonds, guess, dt}; }

  /// Expects that bonds pull with k (l - d) times the mean secant of their ends at the displacements u, and
  /// have the stiffness k times the same.
  void expectSecants(const StepPotential& step, const VectorField& u) const {
    VectorField f = zeros(block.size()), change = f, pull = f;
    Compression at;
    at.resize(block.size());
    step.startForce(u, f, at).add(0, block.size());
    pull[middle].x() = 1e-3f * spacing;
    step.startChange(pull, change, at).add(0, block.size());
    Vectors expected(block.size(), Eigen::Vector3d::Zero()), expected_change = expected;
    for (std::uint32_t i = 0; i < block.size(); ++i) {
      for (const Bond* b = bonds->begin(i); b != bonds->end(i); ++b) {
        const Eigen::Vector3f x = block.position.at(i) - block.position.at(b->other);
        const Eigen::Vector3f moved = u.at(i) - u.at(b->other);
        const Eigen::Vector3d n = x.normalized().cast<double>();
        const double stiffness =
            material.stiffness *
            static_cast<double>(0.5f * spacing * (step.secants.value[i] + step.secants.value[b->other]));
        expected[i] -= stiffness * static_cast<double>((x + moved).norm() - b->rest_length) * n;
        expected_change[i] -= stiffness * n.dot((pull.at(i) - pull.at(b->other)).cast<double>()) * n;
      }
    }
    const Vectors forces = toVectors(f), changes = toVectors(change);
    ASSERT_GT(largest(expected), 0.0);
    for (std::size_t i = 0; i < block.size(); ++i) {
      EXPECT_LT((forces[i] - expected[i]).norm(), 1e-3 * largest(expected));
      EXPECT_LT((changes[i] - expected_change[i]).norm(), 1e-3 * largest(expected_change));
    }
  }

  Material material = bonds_only;
  Particles block = particlesAt(lattice(edge, spacing, 0.0f), 2e-4f);
  VectorField sheared = zeros(block.size());  // m, displacements
  Neighbourhood near{2.0f * spacing};
  std::optional<Bonds> bonds;
  std::optional<Potential> potential;
  // The stress of an elastic lattice is E times the shear, of which 2 E y is left.
  double left = 2.0 * 0.0025 / static_cast<double>(shear);
};

/// Clay that flowed after the last step flows on within this one: a bond pulls with the part of k (l - d)
/// that the flow of its two ends leaves, and its stiffness falls by the same share.
TEST(Potential, BondsYieldWithinAStep) {
  YieldingBlock s;
  for (std::size_t i = 0; i < s.block.size(); ++i) s.block.position.add(i, s.sheared.at(i));
  s.update();
  EXPECT_NEAR(s.bonds->flow().share[s.middle], s.left, static_cast<double>(s.shear) * s.left);
  StepPotential step;
  s.potential->linearise(s.input(s.sheared), {}, step);
  EXPECT_EQ(step.secants.value, s.bonds->flow().secant);
  s.expectSecants(step, s.sheared);
}

/// Clay that begins to yield in a step yields as the displacements of its first round ask for, whatever the
/// guess was. Displacements that strain nothing bring back the elastic bonds.
TEST(Potential, BondsYieldAsDisplacementsAskFor) {
  YieldingBlock s;
  const VectorField rest = zeros(s.block.size());
  StepPotential step;
  s.potential->linearise(s.input(s.sheared), {}, step);
  const double elastic = static_cast<double>(step.secants.value[s.middle]);
  EXPECT_EQ(s.bonds->flow().share[s.middle], 1.0f);
  s.potential->yieldAt(s.sheared, s.input(s.sheared), {}, step);
  EXPECT_NEAR(static_cast<double>(step.secants.value[s.middle]), s.left * elastic,
              static_cast<double>(s.shear) * s.left * elastic);
  s.expectSecants(step, s.sheared);
  s.potential->yieldAt(rest, s.input(s.sheared), {}, step);
  EXPECT_EQ(step.secants.value, s.bonds->flow().secant);
  s.expectSecants(step, s.sheared);
}

TEST(Potential, ForcesSumToZeroAndTurnNothing) {
  for (const Material& m : {density_only, viscosity_only, bonds_only, Material()}) {
    Cloud s(m, 0.95f);
    const Vectors f = s.forceAt(smallMotion(s));
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
    double size = 0.0, arm = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i) {
      sum += f[i];
      torque += s.x(i).cross(f[i]);
      size += f[i].norm();
      arm += f[i].norm() * s.x(i).norm();
    }
    ASSERT_GT(size, 0.0);
    EXPECT_LT(sum.norm(), 1e-5 * size);
    EXPECT_LT(torque.norm(), 1e-5 * arm);
  }
}

TEST(Potential, RigidMotionMeetsNoViscousForce) {
  const Eigen::Matrix3f turn =
      Eigen::AngleAxisf(0.3f, Eigen::Vector3f(2, 1, -1).normalized()).toRotationMatrix();
  Cloud s(viscosity_only);
  const double scale = largest(s.forceAt(smallMotion(s)));  // of a random motion of 0.15 mm
  VectorField rigid = zeros(s.size());
  for (std::size_t i = 0; i < s.size(); ++i) {
    rigid.set(
        i, turn * s.particles.position.at(i) - s.particles.position.at(i) + Eigen::Vector3f(0.01f, 0, 0.02f));
  }
  s.linearise(rigid);
  // up to 4 mm of rotation and 22 mm of translation, to the rounding of single precision
  EXPECT_LT(largest(s.forceAt(rigid)), 2e-4 * scale);
}

/// If the rotation of the step is not that of the guess, the force is of second order in the difference.
TEST(Potential, MissedRotationMeetsASecondOrderForce) {
  const auto forceOf = [](float angle) {
    Cloud s(viscosity_only);
    const Eigen::Matrix3f turn = Eigen::AngleAxisf(angle, Eigen::Vector3f::UnitZ()).toRotationMatrix();
    VectorField u = zeros(s.size());
    for (std::size_t i = 0; i < s.size(); ++i)
      u.set(i, turn * s.particles.position.at(i) - s.particles.position.at(i));
    return largest(s.forceAt(u));  // linearised at rest
  };
  EXPECT_NEAR(forceOf(0.2f) / forceOf(0.1f), 4.0, 0.1);
}

TEST(Potential, ChangeIsLinearSymmetricAndNegativeSemidefinite) {
  for (const Material& m : {density_only, viscosity_only, bonds_only, Material()}) {
    Cloud s(m, 0.95f);
    const VectorField u = smallMotion(s);
    const Vectors at = s.forceAt(u);
    std::mt19937 random(21);
    const VectorField p = randomField(s.size(), random, 1e-4f), q = randomField(s.size(), random, 1e-4f);
    VectorField combined = zeros(s.size()), moved = zeros(s.size());
    for (std::size_t i = 0; i < s.size(); ++i) {
      combined.set(i, 2.0f * p.at(i) - 3.0f * q.at(i));
      moved.set(i, u.at(i) + p.at(i));
    }
    VectorField kp = zeros(s.size()), kq = kp, kc = kp, there = kp;
    s.change(p, kp);
    s.change(q, kq);
    s.change(combined, kc);
    s.step.startForce(moved, there, s.state).add(0, s.size());
    double pkq = 0.0, qkp = 0.0, pkp = 0.0, size = 0.0;
    const double scale = largest(toVectors(kp)), rounding = 1e-5 * largest(at);
    ASSERT_GT(scale, 0.0);
    for (std::size_t i = 0; i < s.size(); ++i) {
      EXPECT_LT((kc.at(i) - 2.0f * kp.at(i) + 3.0f * kq.at(i)).norm(), 1e-5 * 5.0 * scale);
      EXPECT_LT((there.at(i).cast<double>() - at[i] - kp.at(i).cast<double>()).norm(),
                1e-4 * scale + rounding);
      pkq += p.at(i).cast<double>().dot(kq.at(i).cast<double>());
      qkp += q.at(i).cast<double>().dot(kp.at(i).cast<double>());
      pkp += p.at(i).cast<double>().dot(kp.at(i).cast<double>());
      size += p.at(i).norm() * kq.at(i).norm();
    }
    EXPECT_NEAR(pkq, qkp, 1e-6 * size);
    EXPECT_LT(pkp, 0.0);
    // semidefinite also for the smoothest fields, which are the hardest
    VectorField linear = zeros(s.size());
    for (std::size_t i = 0; i < s.size(); ++i)
      linear.set(i, 0.01f * s.particles.position.at(i).x() * Eigen::Vector3f::UnitX());
    s.change(linear, kp);
    double work = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i)
      work += linear.at(i).cast<double>().dot(kp.at(i).cast<double>());
    EXPECT_LE(work, 0.0);
  }
}

/// In one pass, a force and a change are to the bit what each is alone, for any scene's set of families; and
/// C is known where the displacements are, and grows along the direction.
TEST(Potential, ForceAndChangeInOnePassAreThoseOfTwo) {
  for (const Material& m :
       {density_only, viscosity_only, bonds_only, Material(), only(0.0, 0.0, 0.0), only(0.0, 200.0, 1e5)}) {
    Cloud s(m, 0.97f);
    std::mt19937 random(12);
    const VectorField u = smallMotion(s), p = randomField(s.size(), random, 1e-5f);
    VectorField f = zeros(s.size()), change = f, f_alone = f, change_alone = f;
    std::vector<float> compression;
    s.step.startForce(u, f_alone, s.state).add(0, s.size());
    s.change(p, change_alone);
    s.state.follow(1.0f, 0, s.size());
    for (std::size_t i = 0; i < s.size(); ++i) compression.push_back(s.state.acting(i));

    s.step.startForceAndChange(u, f, p, change, s.state).add(0, s.size());
    s.state.follow(1.0f, 0, s.size());
    for (std::size_t i = 0; i < s.size(); ++i) {
      EXPECT_EQ(f.at(i), f_alone.at(i)) << i;
      EXPECT_EQ(change.at(i), change_alone.at(i)) << i;
      EXPECT_EQ(s.state.acting(i), compression[i]) << i;
      EXPECT_TRUE(m.bulk_modulus > 0.0 || storedEnergy(s.step.density, s.state, i) == 0.0) << i;
    }
  }
}

TEST(Potential, DensityIsOneSidedAndOneOnTheLattice) {
  Cloud s(density_only, 1.2f);
  EXPECT_EQ(largest(s.forceAt(zeros(s.size()))), 0.0);  // stretched clay is not drawn together
  std::vector<Material> materials{density_only};
  Potential potential(s.kernel, spacing, materials);
  const Particles particles = particlesAt(lattice(7, spacing, 0.0f), 2e-4f);
  Neighbourhood near(s.kernel.h);
  near.build(particles.position);
  const VectorField rest = zeros(particles.size());
  StepPotential step;
  potential.linearise({near, particles, nullptr, rest, dt}, {}, step);
  EXPECT_NEAR(step.density.ratio[particles.size() / 2], 1.0f, 1e-5f);
}

}  // namespace
}  // namespace tactile_clay::clay::potential_test
