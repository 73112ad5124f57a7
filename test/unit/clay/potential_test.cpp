#include "clay/forces/potential.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>

#include "clay/lattice.h"
#include "clouds.h"

namespace tactile_clay::clay {
namespace {

constexpr float spacing = 0.005f, dt = 1.0f / 240.0f;

using Vectors = std::vector<Eigen::Vector3d>;

Vectors toVectors(const VectorField& f) {
  Vectors v;
  for (std::size_t i = 0; i < f.size(); ++i) v.push_back(f.at(i).cast<double>());
  return v;
}

Material only(double bulk_modulus, double viscosity, double stiffness) {
  Material m;
  m.bulk_modulus = bulk_modulus;
  m.viscosity = viscosity;
  m.stiffness = stiffness;
  return m;
}

const Material density_only = only(1e6, 0.0, 0.0), viscosity_only = only(0.0, 200.0, 0.0),
               bonds_only = only(0.0, 0.0, 1e5);

/// A cloud, its potential and, written down anew in double precision, the energies of the three families.
/// The guess is a rotation of the whole cloud.
struct Cloud {
  explicit Cloud(const Material& material, float scale = 1.0f,
                 const Eigen::Matrix3f& turn_in = Eigen::Matrix3f::Identity())
      : materials{material},
        kernel(2.0f * spacing),
        near(kernel.h),
        bonds(spacing, materials),
        potential(kernel, spacing, materials) {
    particles = particlesAt(lattice(5, scale * spacing, 0.15f), 2e-4f);
    near.build(particles.position);
    bonds.update(near, particles, particles.velocity, true);
    // The positions move on, so that the bonds are strained.
    std::mt19937 random(9);
    for (std::size_t i = 0; i < size(); ++i) particles.position.add(i, randomVector(random, 0.1f * spacing));
    near.build(particles.position);
    bonds.update(near, particles, particles.velocity, true);
    guess = zeros(size());
    for (std::size_t i = 0; i < size(); ++i) {
      guess.set(i, turn_in * particles.position.at(i) - particles.position.at(i));
    }
    linearise(guess);
  }

  void linearise(const VectorField& about, float duration = dt) {
    const Bonds* const held = materials[0].stiffness > 0.0 ? &bonds : nullptr;
    potential.linearise({near, particles, held, about, duration}, {}, step);
    state.resize(size());
  }

  std::size_t size() const { return particles.size(); }
  Eigen::Vector3d x(std::size_t i) const { return particles.position.at(i).cast<double>(); }
  double volume() const { return std::pow(static_cast<double>(spacing), 3.0); }

  template <typename F>
  void forNeighbours(std::size_t i, const F& f) const {
    for (std::size_t j = 0; j < size(); ++j) {
      const Eigen::Vector3d r = x(i) - x(j);
      if (j != i && r.norm() < kernel.h) f(j, r);
    }
  }
  Eigen::Vector3d gradient(const Eigen::Vector3d& r) const {
    return kernel.slope(static_cast<float>(r.norm())) * r / r.norm();
  }

  /// Displacement of i from j beyond that of the guess.
  Eigen::Vector3d beyond(const Vectors& u, std::size_t i, std::size_t j) const {
    return u[i] - u[j] - (guess.at(i) - guess.at(j)).cast<double>();
  }
  Eigen::Vector3d guessed(std::size_t i, std::size_t j) const {
    return x(i) - x(j) + (guess.at(i) - guess.at(j)).cast<double>();
  }
  /// Length of a pair, exact at the guess and linear around it.
  double length(const Vectors& u, std::size_t i, std::size_t j) const {
    return guessed(i, j).norm() + (x(i) - x(j)).normalized().dot(beyond(u, i, j));
  }

  /// sum_i kappa/2 V C_i^2, C_i = rho_i/rho_0 - 1 to first order in u, of those with C_i(at) > 0; V falls
  /// with the square of the density at the start beyond twice.
  double densityEnergy(const Vectors& u, const Vectors& at) const {
    const double rest = latticeSum(kernel, spacing);
    double energy = 0.0;
    for (std::size_t i = 0; i < size(); ++i) {
      double here = kernel.sigma / rest - 1.0, there = here, ratio = kernel.sigma / rest;
      forNeighbours(i, [&](std::size_t j, const Eigen::Vector3d& r) {
        const double w = kernel.value(static_cast<float>(guessed(i, j).norm()));
        ratio += kernel.value(static_cast<float>(r.norm())) / rest;
        here += (w + gradient(r).dot(beyond(u, i, j))) / rest;
        there += (w + gradient(r).dot(beyond(at, i, j))) / rest;
      });
      const double less = std::pow(2.0 / std::max(ratio, 2.0), 2.0);
      if (there > 0.0) energy += 0.5 * materials[0].bulk_modulus * less * volume() * here * here;
    }
    return energy;
  }

  /// Dashpots along pairs, w = (1 - q^2)^3 r^2, scaled for each particle so that sum_j w r^2 is that of the
  /// lattice; a pair has the mean of both.
  double viscousEnergy(const Vectors& u) const {
    const auto weight = [&](double r) {
      return std::pow(1.0 - std::pow(r / static_cast<double>(kernel.h), 2.0), 3.0) * r * r;
    };
    double whole = 0.0;
    for (int k = 0; k < 27; ++k) {
      if (k == 13) continue;
      const double r = spacing * Eigen::Vector3d(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1).norm();
      whole += weight(r) * r * r;
    }
    std::vector<double> share(size(), 0.0);
    for (std::size_t i = 0; i < size(); ++i) {
      forNeighbours(i, [&](std::size_t, const Eigen::Vector3d& r) {
        share[i] += weight(r.norm()) * r.squaredNorm() / whole;
      });
      share[i] = std::max(share[i], 0.25);
    }
    double energy = 0.0;
    for (std::size_t i = 0; i < size(); ++i) {
      forNeighbours(i, [&](std::size_t j, const Eigen::Vector3d& r) {
        if (j < i) return;
        const double k = 30.0 * materials[0].viscosity * volume() / whole * weight(r.norm()) / dt;
        const double strain = length(u, i, j) - r.norm();
        energy += 0.5 * k * 0.5 * (1.0 / share[i] + 1.0 / share[j]) * strain * strain;
      });
    }
    return energy;
  }

  /// Sum of k/2 (l - d)^2 over the bonds. k is the mean of the values with which sum k d^2 of each end is
  /// that of the lattice, 30 E d^3; at a surface only half of what is lacking is made up for, and at most
  /// that of a flat surface.
  double bondEnergy(const Vectors& u) const {
    const double k = materials[0].stiffness * spacing;
    std::vector<double> share;
    for (std::size_t i = 0; i < size(); ++i) {
      double squares = 0.0;
      for (const Bond* b = bonds.begin(i); b != bonds.end(i); ++b)
        squares += std::pow(static_cast<double>(b->rest_length / spacing), 2.0) / 30.0;
      squares = std::max(squares, 21.0 / 30.0);
      share.push_back(1.0 / (squares < 1.0 ? std::sqrt(squares) : squares));
    }
    double energy = 0.0;
    for (std::size_t i = 0; i < size(); ++i) {
      for (const Bond* b = bonds.begin(i); b != bonds.end(i); ++b) {
        if (b->other < i) continue;
        const double strain = length(u, i, b->other) - b->rest_length;
        energy += 0.5 * k * 0.5 * (share[i] + share[b->other]) * strain * strain;
      }
    }
    return energy;
  }

  Vectors forceAt(const VectorField& u) {
    VectorField f = zeros(size());
    step.startForce(u, f, state).add(0, size());
    return toVectors(f);
  }
  void change(const VectorField& p, VectorField& f) { step.startChange(p, f, state).add(0, size()); }
  const std::vector<float>& densityRatio() const { return step.density.ratio; }
  float paid(std::size_t i) const { return paidCompression(step.density, state, i); }

  std::vector<Material> materials;
  Kernel kernel;
  Neighbourhood near;
  Bonds bonds;
  Potential potential;
  StepPotential step;
  Compression state;
  Particles particles;
  VectorField guess;
};

double largest(const Vectors& f) {
  double size = 0.0;
  for (const Eigen::Vector3d& v : f) size = std::max(size, v.norm());
  return size;
}

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

VectorField smallMotion(const Cloud& s) {
  std::mt19937 random(11);
  VectorField u = randomField(s.size(), random, 0.03f * spacing);
  for (std::size_t i = 0; i < s.size(); ++i) u.add(i, s.guess.at(i));
  return u;
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

/// Clay that flowed after the last step flows on within this one: a bond pulls with the part of k (l - d)
/// that the flow of its two ends leaves, and its stiffness falls by the same share.
TEST(Potential, BondsYieldWithinAStep) {
  Material material = bonds_only;
  material.yield_strain = 0.0025;
  material.unbond_rate = 1e9;
  constexpr int edge = 7;
  constexpr std::uint32_t middle = edge * edge * edge / 2;
  constexpr float shear = 0.03f;
  Bonds bonds(spacing, {material});
  Potential potential(Kernel(2.0f * spacing), spacing, {material});
  Neighbourhood near(2.0f * spacing);
  Particles block = particlesAt(lattice(edge, spacing, 0.0f), 2e-4f);
  VectorField guess = zeros(block.size()), f = guess, change = guess, pull = guess;
  for (std::size_t i = 0; i < block.size(); ++i) guess[i].x() = shear * block.position[i].y();
  for (const bool strained : {false, true}) {
    if (strained)
      for (std::size_t i = 0; i < block.size(); ++i) block.position.add(i, guess.at(i));
    near.build(block.position);
    bonds.update(near, block, block.velocity, true);
  }
  const Flow& flow = bonds.flow();
  // In the middle the stress was that of an elastic lattice, E times the shear, of which 2 E y is left.
  const double left = 2.0 * material.yield_strain / static_cast<double>(shear);
  EXPECT_NEAR(flow.share[middle], left, static_cast<double>(shear) * left);
  StepPotential step;
  potential.linearise({near, block, &bonds, guess, dt}, {}, step);
  Compression at;
  at.resize(block.size());
  step.startForce(guess, f, at).add(0, block.size());
  pull[middle].x() = 1e-3f * spacing;
  step.startChange(pull, change, at).add(0, block.size());
  Vectors expected(block.size(), Eigen::Vector3d::Zero()), expected_change = expected;
  for (std::uint32_t i = 0; i < block.size(); ++i) {
    for (const Bond* b = bonds.begin(i); b != bonds.end(i); ++b) {
      const Eigen::Vector3f x = block.position.at(i) - block.position.at(b->other);
      const Eigen::Vector3f moved = guess.at(i) - guess.at(b->other);
      const Eigen::Vector3d n = x.normalized().cast<double>();
      const double stiffness =
          material.stiffness * static_cast<double>(0.5f * spacing * (flow.secant[i] + flow.secant[b->other]));
      expected[i] -= stiffness * static_cast<double>((x + moved).norm() - b->rest_length) * n;
      expected_change[i] -= stiffness * n.dot((pull.at(i) - pull.at(b->other)).cast<double>()) * n;
    }
  }
  const Vectors forces = toVectors(f), changes = toVectors(change);
  for (std::size_t i = 0; i < block.size(); ++i) {
    EXPECT_LT((forces[i] - expected[i]).norm(), 1e-3 * largest(expected));
    EXPECT_LT((changes[i] - expected_change[i]).norm(), 1e-3 * largest(expected_change));
  }
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

/// Density gives back no more of a compression than the last step left, plus the kinetic energy of 0.5 m/s.
TEST(Potential, CompressionBeyondThatOfTheLastStepPushesLittle) {
  Cloud s(density_only, 0.93f);
  const VectorField rest = zeros(s.size());
  const std::vector<float> ratio = s.densityRatio();
  const auto energy = [&](float share) {  // J, of the most compressed
    for (std::size_t i = 0; i < s.size(); ++i)
      s.particles.compression[i] = share * std::max(ratio[i] - 1.0f, 0.0f);
    s.linearise(rest);
    s.forceAt(rest);
    const double stiffness = density_only.bulk_modulus * std::pow(spacing, 3.0);
    double maximum = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i)
      maximum = std::max(maximum, 0.5 * stiffness * std::pow(s.state.acting(i), 2.0));
    return maximum;
  };
  const double whole = energy(1.0f), of_half_a_metre_a_second = 0.5 * 0.25 / s.particles.inverse_mass[0];
  ASSERT_GT(whole, 2.0 * of_half_a_metre_a_second);
  EXPECT_NEAR(energy(0.5f), 0.25 * whole + of_half_a_metre_a_second, 1e-4 * whole);
  EXPECT_NEAR(energy(0.0f), of_half_a_metre_a_second, 1e-4 * whole);
}

/// The energy that a particle was lent for this is taken back at the end of the step, except the kinetic
/// energy of 0.1 m/s. Otherwise a particle that others keep squeezed would be lent it again and again.
TEST(Potential, CompressionThatWasLentIsNotKept) {
  Cloud s(density_only, 0.93f);
  const VectorField rest = zeros(s.size());
  const double stiffness = density_only.bulk_modulus * std::pow(spacing, 3.0);
  const double kept = 0.5 * 0.01 / s.particles.inverse_mass[0];  // J
  const std::vector<float> ratio = s.densityRatio();
  const auto maximum = std::max_element(ratio.begin(), ratio.end()) - ratio.begin();
  const float whole = ratio[maximum] - 1.0f;
  s.particles.compression[maximum] = 0.5f * whole;
  for (int k = 1; k <= 5; ++k) {
    s.linearise(rest);
    s.forceAt(rest);
    const double paid = s.paid(maximum);
    EXPECT_NEAR(0.5 * stiffness * (paid * paid - 0.25 * whole * whole), k * kept, 0.01 * kept);
    EXPECT_LT(paid, s.state.acting(maximum));
    s.particles.compression[maximum] = static_cast<float>(paid);
  }
}

/// Clay that is pressed to many times its density, as between palms that leave no room, gives back no more
/// than clay that is pressed to twice its density.
TEST(Potential, CompressionIsKeptUpToTwiceTheDensity) {
  Cloud s(density_only, 0.6f);
  const VectorField rest = zeros(s.size());
  const std::vector<float> ratio = s.densityRatio();
  for (std::size_t i = 0; i < s.size(); ++i) s.particles.compression[i] = std::max(ratio[i] - 1.0f, 0.0f);
  s.linearise(rest);
  s.forceAt(rest);
  int more = 0, less = 0;
  for (std::size_t i = 0; i < s.size(); ++i) {
    (ratio[i] > 2.01f ? more : less) += 1;
    EXPECT_NEAR(s.state.acting(i), std::max(ratio[i] - 1.0f, 0.0f), 2e-3f * ratio[i]) << i;
    EXPECT_NEAR(s.paid(i), std::clamp(ratio[i] - 1.0f, 0.0f, 1.0f), 2e-3f) << i;
  }
  EXPECT_GT(more, 10);
  EXPECT_GT(less, 10);
}

/// Compression that may not push is undone by displacements whose sum is zero.
TEST(Potential, CompressionBeyondThatOfTheLastStepIsUndone) {
  Cloud s(density_only, 0.93f);
  std::fill(s.particles.compression.begin(), s.particles.compression.end(), 0.0f);
  const auto compression = [&] {
    double total = 0.0;
    for (const float ratio : s.densityRatio()) total += std::max(ratio - 1.0f, 0.0f);
    return total;
  };
  const VectorField rest = zeros(s.size());
  VectorField w = rest;
  const double before = compression();
  for (int k = 0; k < 100; ++k) {
    s.near.build(s.particles.position);
    s.linearise(rest);
    ASSERT_EQ(s.step.excessive, k == 0 || compression() > 0.0);
    s.step.recover(s.state, w);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double farthest = 0.0;
    for (std::size_t i = 0; i < s.size(); ++i) {
      sum += w.at(i).cast<double>();
      farthest = std::max<double>(farthest, w.at(i).norm());
      s.particles.position[i] += w[i];
    }
    EXPECT_LE(sum.norm(), 1e-6 * farthest * static_cast<double>(s.size()));
    EXPECT_LT(farthest, 0.5 * dt);
  }
  EXPECT_LT(compression(), 0.2 * before);
}

/// Gradients are those at the start of the step; in a long step 0.5 m/s would move particles many spacings
/// along them.
TEST(Potential, CompressionIsUndoneByHalfASpacingAStepAtMost) {
  constexpr float long_step = 0.1f;
  std::vector<Eigen::Vector3f> points = lattice(3, 1e-3f * spacing, 0.0f);
  Cloud s(density_only, 1.0f);
  s.particles = particlesAt(points, 2e-4f);
  std::fill(s.particles.compression.begin(), s.particles.compression.end(), 0.0f);
  const VectorField rest = zeros(points.size());
  VectorField w = rest;
  s.near.build(s.particles.position);
  s.linearise(rest, long_step);
  ASSERT_TRUE(s.step.excessive);
  s.step.recover(s.state, w);
  double farthest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) farthest = std::max<double>(farthest, w.at(i).norm());
  EXPECT_GT(farthest, 0.01 * spacing);
  EXPECT_LT(farthest, 2.0 * spacing);
}

/// As in a closing fist: each particle undoes as much as it can, and all this adds up.
TEST(Potential, CompressionOfManyInOnePlaceIsUndoneByNoLeap) {
  const std::vector<Eigen::Vector3f> points = lattice(6, 0.1f * spacing, 0.0f);
  Cloud s(density_only, 1.0f);
  s.particles = particlesAt(points, 2e-4f);
  std::fill(s.particles.compression.begin(), s.particles.compression.end(), 0.0f);
  const VectorField rest = zeros(points.size());
  s.near.build(s.particles.position);
  for (const float step : {0.1f, 0.004f}) {
    VectorField w = rest;
    s.linearise(rest, step);
    ASSERT_TRUE(s.step.excessive);
    s.step.recover(s.state, w);
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_LE(w.at(i).norm(), 1.001f * std::min(spacing, 1.0f * step));  // 1 m/s
  }
}

/// Power that shears a cube of the initial lattice in a step of `step` s, over eta gamma^2 volume.
double shearPower(int side, const Eigen::Matrix3f& turn, float step) {
  std::vector<Material> materials{viscosity_only};
  const Kernel kernel(2.0f * spacing);
  Potential potential(kernel, spacing, materials);
  const Particles particles = particlesAt(lattice(side, spacing, 0.0f), 2e-4f);
  Neighbourhood near(kernel.h);
  near.build(particles.position);
  const double volume = static_cast<double>(particles.size()) * std::pow(static_cast<double>(spacing), 3.0);
  const float rate = 0.1f;  // 1/s
  VectorField u = zeros(particles.size()), f = u;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const Eigen::Vector3f local = turn.transpose() * particles.position.at(i);
    u.set(i, turn * Eigen::Vector3f(rate * step * local.z(), 0.0f, 0.0f));
  }
  const VectorField rest = zeros(particles.size());
  Compression at;
  at.resize(particles.size());
  StepPotential linear;
  potential.linearise({near, particles, nullptr, rest, step}, {}, linear);
  linear.startForce(u, f, at).add(0, u.size());
  double watts = 0.0;
  for (std::size_t i = 0; i < particles.size(); ++i)
    watts -= f.at(i).dot(u.at(i)) / static_cast<double>(step);
  return watts / (viscosity_only.viscosity * rate * rate * volume);
}

/// A Newtonian fluid in simple shear takes eta gamma^2 watts per cubic metre, whatever the step. Averaged
/// over directions this is exact, at surfaces as well as inside.
TEST(Potential, ViscosityIsInPascalSeconds) {
  for (const float step : {1e-3f, 1e-2f}) {
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    double mean = 0.0;
    const int turns = 300;
    for (int k = 0; k < turns; ++k) {
      const Eigen::Quaternionf turn(normal(random), normal(random), normal(random), normal(random));
      mean += shearPower(4, turn.normalized().toRotationMatrix(), step) / turns;
    }
    EXPECT_NEAR(mean, 1.0, 0.02) << step;
  }
}

/// The lattice of the start is cubic, not isotropic. The part of the faces of a cube falls with its size, and
/// is eliminated with two sizes.
TEST(Potential, ViscosityIsNearlyIsotropicInside) {
  const Eigen::Matrix3f along_axes = Eigen::Matrix3f::Identity();
  const Eigen::Matrix3f along_diagonals =
      Eigen::AngleAxisf(static_cast<float>(M_PI) / 4.0f, Eigen::Vector3f::UnitY()).toRotationMatrix();
  for (const Eigen::Matrix3f& turn : {along_axes, along_diagonals}) {
    const double inside = (16.0 * shearPower(16, turn, 1e-2f) - 6.0 * shearPower(6, turn, 1e-2f)) / 10.0;
    EXPECT_NEAR(inside, 1.0, 0.05);
  }
}

}  // namespace
}  // namespace tactile_clay::clay
