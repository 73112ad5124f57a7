#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "clay/forces/bonds.h"
#include "clay/forces/potential.h"
#include "clay/lattice.h"
#include "clouds.h"
#include "support/vectors.h"

/// A cloud of particles and its potential, for the tests of forces.
namespace tactile_clay::clay::potential_cloud {

constexpr float spacing = 0.005f, dt = 1.0f / 240.0f;

inline Material only(double bulk_modulus, double viscosity, double stiffness) {
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

  /// Dashpots along pairs, w = (1 - q^2)^2 (1 - 28/31 q^2) r^2, scaled for each particle so that sum_j w r^2
  /// is that of the lattice; a pair has the mean of both.
  double viscousEnergy(const Vectors& u) const {
    const auto weight = [&](double r) {
      const double q_square = std::pow(r / static_cast<double>(kernel.h), 2.0);
      return std::pow(1.0 - q_square, 2.0) * (1.0 - 28.0 / 31.0 * q_square) * r * r;
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

inline double largest(const Vectors& f) {
  double size = 0.0;
  for (const Eigen::Vector3d& v : f) size = std::max(size, v.norm());
  return size;
}

inline VectorField smallMotion(const Cloud& s) {
  std::mt19937 random(11);
  VectorField u = randomField(s.size(), random, 0.03f * spacing);
  for (std::size_t i = 0; i < s.size(); ++i) u.add(i, s.guess.at(i));
  return u;
}

}  // namespace tactile_clay::clay::potential_cloud
