// The oracle: one time step of free clay written down plainly in double precision, with all pairs and dense
// matrices, as doc/method.md defines it. It shares nothing with the solver but the kernel.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "clay/clay.h"
#include "clay/kernel.h"
#include "clay/lattice.h"
#include "support/setups.h"

namespace tactile_clay::clay {
namespace {

constexpr double spacing = 0.005;

using Vectors = std::vector<Eigen::Vector3d>;

struct Pair {
  std::size_t i, j;
  Eigen::Vector3d x;   // m, x_i - x_j at the start
  double stiffness;    // N/m^3, of the force s (x . du) x on i
  double push;         // N/m, the force on i at u = 0 is push x
  double compression;  // 1/m^2, C_i and C_j grow by compression (x . du)
};

Vectors toVectors(const VectorField& field) {
  Vectors all;
  for (std::size_t i = 0; i < field.size(); ++i) all.push_back(field.at(i).cast<double>());
  return all;
}

/// Displacements of the step that begins as in `before`. \param bonds those of the step
Vectors referenceStep(const Sculpture& before, const Sculpture& bonds, const Material& material,
                      const Eigen::Vector3d& gravity, double dt) {
  const Kernel kernel(static_cast<float>(2.0 * spacing));
  const double h = 2.0 * spacing, volume = std::pow(spacing, 3.0), mass = material.density * volume;
  const double lattice = latticeSum(kernel, static_cast<float>(spacing));
  const Vectors x = toVectors(before.position), v = toVectors(before.velocity);
  const std::size_t n = x.size();
  Vectors free;
  for (std::size_t i = 0; i < n; ++i) free.push_back(dt * v[i] + dt * dt * gravity);

  // Dashpots weigh (1 - q^2)^3; amended where a surface takes some away.
  const auto weight = [&](double r) { return std::pow(std::max(1.0 - r * r / (h * h), 0.0), 3.0); };
  double lattice_dashpots = 0.0;
  for (int a = -1; a <= 1; ++a)
    for (int b = -1; b <= 1; ++b)
      for (int c = -1; c <= 1; ++c) {
        const double r = spacing * std::sqrt(a * a + b * b + c * c);
        lattice_dashpots += weight(r) * std::pow(r, 4.0);
      }
  std::vector<double> amend(n, 0.0), excess(n, kernel.sigma / lattice - 1.0);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      const double r = (x[i] - x[j]).norm();
      amend[i] += weight(r) * std::pow(r, 4.0) / lattice_dashpots;
    }
    amend[i] = 1.0 / std::max(amend[i], 0.25);
  }
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      Pair pair{i, j, x[i] - x[j], 0.0, 0.0, 0.0};
      const double r = pair.x.norm();
      if (r >= h) continue;
      const Eigen::Vector3d guess = free[j] - free[i];
      const double along = pair.x.dot(guess), length = (pair.x - guess).norm();
      const double dashpot = 30.0 * volume * material.viscosity / lattice_dashpots / dt * weight(r) * 0.5 *
                             (amend[i] + amend[j]);
      double spring = 0.0, rest = 0.0;
      for (std::uint32_t b = bonds.bond_begin[i]; b < bonds.bond_begin[i + 1]; ++b) {
        if (bonds.bonds[b].other != j) continue;
        spring = material.stiffness * spacing / (r * r);
        rest = bonds.bonds[b].rest_length;
      }
      const double start = length + along / r;  // the length at u = 0, linear about the guess
      pair.stiffness = dashpot + spring;
      pair.push = r * (dashpot * (r - start) + spring * (rest - start));
      pair.compression = -kernel.slope(static_cast<float>(r)) / (r * lattice);
      for (const std::size_t k : {i, j})
        excess[k] += kernel.value(static_cast<float>(length)) / lattice - pair.compression * along;
      pairs.push_back(pair);
    }
  }

  // M (u - free) / dt^2 = forces, linear for each set of compressed particles; Newton's method over the sets.
  const auto size = static_cast<Eigen::Index>(3 * n);
  Eigen::VectorXd u(size);
  for (std::size_t i = 0; i < n; ++i) u.segment<3>(3 * i) = free[i];
  std::vector<bool> compressed(n, false);
  for (int round = 0; round < 50; ++round) {
    Eigen::MatrixXd growth = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n), size);  // dC / du
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd f = Eigen::VectorXd::Zero(size);
    for (std::size_t i = 0; i < n; ++i) {
      a.block<3, 3>(3 * i, 3 * i).diagonal().setConstant(mass / (dt * dt));
      f.segment<3>(3 * i) = mass / (dt * dt) * free[i];
    }
    for (const Pair& p : pairs) {
      const Eigen::Matrix3d s = p.stiffness * p.x * p.x.transpose();
      a.block<3, 3>(3 * p.i, 3 * p.i) += s, a.block<3, 3>(3 * p.j, 3 * p.j) += s;
      a.block<3, 3>(3 * p.i, 3 * p.j) -= s, a.block<3, 3>(3 * p.j, 3 * p.i) -= s;
      f.segment<3>(3 * p.i) += p.push * p.x, f.segment<3>(3 * p.j) -= p.push * p.x;
      for (const std::size_t k : {p.i, p.j}) {
        growth.block<1, 3>(k, 3 * p.j) += p.compression * p.x.transpose();
        growth.block<1, 3>(k, 3 * p.i) -= p.compression * p.x.transpose();
      }
    }
    const double kappa = material.bulk_modulus * volume;
    for (std::size_t i = 0; i < n; ++i) {
      if (!compressed[i]) continue;
      a += kappa * growth.row(i).transpose() * growth.row(i);
      f -= kappa * excess[i] * growth.row(i).transpose();
    }
    u = a.llt().solve(f);
    const Eigen::VectorXd grown = growth * u;
    bool same = true;
    for (std::size_t i = 0; i < n; ++i) {
      const bool now = excess[i] + grown[static_cast<Eigen::Index>(i)] > 0.0;
      same = same && now == compressed[i];
      compressed[i] = now;
    }
    if (same) {
      Vectors moved;
      for (std::size_t i = 0; i < n; ++i) moved.push_back(u.segment<3>(3 * i));
      return moved;
    }
  }
  ADD_FAILURE() << "the set of compressed particles does not settle";
  return free;
}

struct Case {
  const char* name;
  double viscosity, stiffness, bulk_modulus;
};
class ReferenceStep : public testing::TestWithParam<Case> {};

/// Two steps of a squeezed, stirred block in free fall, solved to the end. Tolerance: 1e-3 of how much
/// internal forces change the displacements, five times what single precision leaves of the lengths.
TEST_P(ReferenceStep, IsWhatTheSolverConvergesTo) {
  Material material;
  material.viscosity = GetParam().viscosity;
  material.stiffness = GetParam().stiffness;
  material.bulk_modulus = GetParam().bulk_modulus;
  std::mt19937 random(7);
  std::normal_distribution<float> jitter(0.0f, 1.0f);
  auto particles = block(5, 4, 4, spacing);
  for (InitialParticle& p : particles) {
    p.position *= 0.98f;
    for (int a = 0; a < 3; ++a) {
      p.position[a] += 2e-4f * jitter(random);
      p.velocity[a] = 0.02f * jitter(random);
    }
  }
  ClayConfig config;
  config.spacing = spacing;
  config.threads = 1;
  config.budget = {4, 4000};
  config.tolerance = 0.0;
  Clay clay(config, {material}, particles);
  const double dt = config.frame / 4.0;
  for (int step = 0; step < 2; ++step) {
    const Sculpture before = clay.sculpture();
    clay.advance({}, {}, dt);
    const Sculpture after = clay.sculpture();
    const Vectors expected = referenceStep(before, after, material, config.gravity, dt);
    double worst = 0.0, internal = 0.0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const Eigen::Vector3d free = dt * before.velocity.at(i).cast<double>() + dt * dt * config.gravity;
      const Eigen::Vector3d moved = dt * after.velocity.at(i).cast<double>();
      worst = std::max(worst, (moved - expected[i]).norm());
      internal = std::max(internal, (expected[i] - free).norm());
    }
    if (step == 0) {  // later, density alone has nothing left to drive apart
      EXPECT_GT(internal, 1e-6);
    }
    EXPECT_LT(worst, 1e-3 * internal + 1e-9)
        << "step " << step << ", internal forces move by " << internal << " m";
  }
}

INSTANTIATE_TEST_SUITE_P(Clay, ReferenceStep,
                         testing::Values(Case{"viscosity", 200.0, 0.0, 0.0}, Case{"bonds", 0.0, 1e5, 0.0},
                                         Case{"density", 0.0, 0.0, 1e6}, Case{"all", 200.0, 1e5, 1e6}),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace tactile_clay::clay
