#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include "clay/clay.h"
#include "clay/kernel.h"
#include "clay/lattice.h"
#include "clay/sculpture.h"
#include "support/vectors.h"

/// The reference: one time step of free clay written down plainly, in double precision and one thread, as
/// doc/method/clay.md defines it. It shares nothing with the solver but the kernel.
namespace tactile_clay::clay {

struct ReferencePair {
  std::size_t i, j;
  Eigen::Vector3d x;   // m, x_i - x_j at the start
  double stiffness;    // N/m^3, of the force s (x . du) x on i
  double push;         // N/m, the force on i at u = 0 is push x
  double compression;  // 1/m^2, C_i and C_j grow by compression (x . du)
};

/// Calls f(i, j) for each j < i closer than h.
template <typename F>
void forPairsWithin(double h, const Vectors& x, const F& f) {
  using Cell = std::tuple<int, int, int>;
  const auto cellOf = [h](const Eigen::Vector3d& at) {
    return Cell(static_cast<int>(std::floor(at.x() / h)), static_cast<int>(std::floor(at.y() / h)),
                static_cast<int>(std::floor(at.z() / h)));
  };
  std::map<Cell, std::vector<std::size_t>> cells;
  for (std::size_t i = 0; i < x.size(); ++i) cells[cellOf(x[i])].push_back(i);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const auto [cx, cy, cz] = cellOf(x[i]);
    for (int a = -1; a <= 1; ++a) {
      for (int b = -1; b <= 1; ++b) {
        for (int c = -1; c <= 1; ++c) {
          const auto cell = cells.find(Cell(cx + a, cy + b, cz + c));
          if (cell == cells.end()) continue;
          for (const std::size_t j : cell->second)
            if (j < i && (x[i] - x[j]).norm() < h) f(i, j);
        }
      }
    }
  }
}

/// How stiff the bonds of each particle are, over E d: what makes sum k l^2 over their rest lengths, of a
/// neighbourhood that has them all, 30 E d^3; half as much of what a surface takes away, a flat one at most.
/// @param before the step, in which rest lengths of old bonds are looked up
/// @param bonds those of the step
inline std::vector<double> bondStiffness(const Sculpture& before, const Sculpture& bonds) {
  std::vector<double> stiffness;
  for (std::size_t i = 0; i < before.position.size(); ++i) {
    double squares = 0.0;
    for (std::uint32_t b = bonds.bond_begin[i]; b < bonds.bond_begin[i + 1]; ++b) {
      double length = bonds.bonds[b].rest_length;
      for (std::uint32_t a = before.bond_begin[i]; a < before.bond_begin[i + 1]; ++a)
        if (before.bonds[a].other == bonds.bonds[b].other) length = before.bonds[a].rest_length;
      squares += length * length;
    }
    const double ratio = std::max(squares / (30.0 * before.spacing * before.spacing), 21.0 / 30.0);
    stiffness.push_back(1.0 / (ratio < 1.0 ? std::sqrt(ratio) : ratio));
  }
  return stiffness;
}

/// The equations of a step, in the displacements u of its particles.
struct ReferenceSystem {
  double inertia, kappa;       // N/m, m / dt^2; J, K d^3
  Vectors free;                // m, u without forces between particles
  std::vector<double> excess;  // C_i at u = 0
  std::vector<ReferencePair> pairs;
  std::vector<bool> compressed;  // which particles have C_i > 0, where it was looked at last
};

/// Dashpots weigh (1 - q^2)^2 (1 - 28/31 q^2).
inline double dashpotWeight(double r, double h) {
  const double q_square = r * r / (h * h);
  return std::pow(std::max(1.0 - q_square, 0.0), 2.0) * (1.0 - 28.0 / 31.0 * q_square);
}

/// m^4, over the dashpots of an inner particle of a lattice.
inline double latticeOfDashpots(double spacing) {
  double sum = 0.0;
  for (int a = -1; a <= 1; ++a)
    for (int b = -1; b <= 1; ++b)
      for (int c = -1; c <= 1; ++c) {
        const double r = spacing * std::sqrt(a * a + b * b + c * c);
        sum += dashpotWeight(r, 2.0 * spacing) * std::pow(r, 4.0);
      }
  return sum;
}

/// By what dashpots of each particle are multiplied where a surface takes some away.
inline std::vector<double> amendedDashpots(const Vectors& x, double spacing) {
  const double h = 2.0 * spacing, lattice_dashpots = latticeOfDashpots(spacing);
  std::vector<double> amend(x.size(), 0.0);
  forPairsWithin(h, x, [&](std::size_t i, std::size_t j) {
    const double r = (x[i] - x[j]).norm(), share = dashpotWeight(r, h) * std::pow(r, 4.0) / lattice_dashpots;
    amend[i] += share;
    amend[j] += share;
  });
  for (double& a : amend) a = 1.0 / std::max(a, 0.25);
  return amend;
}

/// The equations of the step that begins as in `before`.
/// @param bonds those of the step
inline ReferenceSystem referenceSystem(const Sculpture& before, const Sculpture& bonds,
                                       const Material& material, const Eigen::Vector3d& gravity, double dt) {
  const double spacing = before.spacing, h = 2.0 * spacing;
  const Kernel kernel(static_cast<float>(h));
  const double volume = std::pow(spacing, 3.0), mass = material.density * volume;
  const double lattice = latticeSum(kernel, static_cast<float>(spacing));
  const Vectors x = toVectors(before.position), v = toVectors(before.velocity);
  const std::size_t n = x.size();
  ReferenceSystem system;
  system.inertia = mass / (dt * dt);
  system.kappa = material.bulk_modulus * volume;
  for (std::size_t i = 0; i < n; ++i) system.free.push_back(dt * v[i] + dt * dt * gravity);
  system.excess.assign(n, kernel.sigma / lattice - 1.0);
  system.compressed.resize(n);

  const double lattice_dashpots = latticeOfDashpots(spacing);
  const std::vector<double> amend = amendedDashpots(x, spacing);
  const std::vector<double> share_of_bonds = bondStiffness(before, bonds);
  forPairsWithin(h, x, [&](std::size_t i, std::size_t j) {
    ReferencePair pair{i, j, x[i] - x[j], 0.0, 0.0, 0.0};
    const double r = pair.x.norm();
    const Eigen::Vector3d guess = system.free[j] - system.free[i];
    const double along = pair.x.dot(guess), length = (pair.x - guess).norm();
    const double dashpot = 30.0 * volume * material.viscosity / lattice_dashpots / dt * dashpotWeight(r, h) *
                           0.5 * (amend[i] + amend[j]);
    double spring = 0.0, rest = 0.0;
    for (std::uint32_t b = bonds.bond_begin[i]; b < bonds.bond_begin[i + 1]; ++b) {
      if (bonds.bonds[b].other != j) continue;
      spring = material.stiffness * spacing / (r * r) * 0.5 * (share_of_bonds[i] + share_of_bonds[j]);
      rest = bonds.bonds[b].rest_length;
    }
    const double start = length + along / r;  // the length at u = 0, linear about the guess
    pair.stiffness = dashpot + spring;
    pair.push = r * (dashpot * (r - start) + spring * (rest - start));
    pair.compression = -kernel.slope(static_cast<float>(r)) / (r * lattice);
    for (const std::size_t k : {i, j})
      system.excess[k] += kernel.value(static_cast<float>(length)) / lattice - pair.compression * along;
    system.pairs.push_back(pair);
  });
  for (std::size_t i = 0; i < n; ++i)  // beyond what the last step ended with, the energy of 0.5 m/s at most
    system.excess[i] = std::min(system.excess[i],
                                std::sqrt(std::pow(before.compression[i], 2.0) + 0.25 * mass / system.kappa));
  return system;
}

/// Growth of each C_i, linear in u.
inline std::vector<double> growthOf(const ReferenceSystem& system, const Vectors& u) {
  std::vector<double> growth(u.size(), 0.0);
  for (const ReferencePair& p : system.pairs) {
    const double grown = p.compression * p.x.dot(u[p.j] - u[p.i]);
    growth[p.i] += grown;
    growth[p.j] += grown;
  }
  return growth;
}

/// Adds the forces, N, by which compressed particles push others away.
/// @param c each C_i
inline void addPressure(const ReferenceSystem& system, const std::vector<double>& c, Vectors& force) {
  for (const ReferencePair& p : system.pairs) {
    const double pressure =
        system.kappa * ((system.compressed[p.i] ? c[p.i] : 0.0) + (system.compressed[p.j] ? c[p.j] : 0.0)) *
        p.compression;
    force[p.i] += pressure * p.x;
    force[p.j] -= pressure * p.x;
  }
}

/// Forces that are not in balance at u, N. Looks anew which particles are compressed.
inline Vectors residual(ReferenceSystem& system, const Vectors& u) {
  std::vector<double> c = growthOf(system, u);
  for (std::size_t i = 0; i < u.size(); ++i) {
    c[i] += system.excess[i];
    system.compressed[i] = c[i] > 0.0;
  }
  Vectors r(u.size());
  for (std::size_t i = 0; i < u.size(); ++i) r[i] = system.inertia * (system.free[i] - u[i]);
  for (const ReferencePair& p : system.pairs) {
    const Eigen::Vector3d force = (p.push + p.stiffness * p.x.dot(u[p.j] - u[p.i])) * p.x;
    r[p.i] += force;
    r[p.j] -= force;
  }
  addPressure(system, c, r);
  return r;
}

/// By how much these forces change with u, N.
inline Vectors multiply(const ReferenceSystem& system, const Vectors& u) {
  Vectors product(u.size(), Eigen::Vector3d::Zero());
  for (const ReferencePair& p : system.pairs) {
    const Eigen::Vector3d force = p.stiffness * p.x.dot(u[p.j] - u[p.i]) * p.x;
    product[p.i] += force;
    product[p.j] -= force;
  }
  addPressure(system, growthOf(system, u), product);
  for (std::size_t i = 0; i < u.size(); ++i) product[i] = system.inertia * u[i] - product[i];
  return product;
}

inline double dot(const Vectors& a, const Vectors& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

/// Displacements of the step that begins as in `before`, without contacts: conjugate gradients,
/// preconditioned by mass; which particles are compressed is looked at anew every `a_round` iterations.
/// @param bonds those of the step
/// @param iterations at most; it ends where all forces are in balance, to 1e-10
inline Vectors referenceStep(const Sculpture& before, const Sculpture& bonds, const Material& material,
                             const Eigen::Vector3d& gravity, double dt, int iterations, int a_round) {
  ReferenceSystem system = referenceSystem(before, bonds, material, gravity, dt);
  Vectors u = system.free;
  double first = -1.0;
  for (int left = iterations; left > 0; left -= a_round) {
    Vectors r = residual(system, u), p = r;
    double rr = dot(r, r);
    if (first < 0.0) first = rr;
    if (rr <= 1e-20 * first) break;
    for (int k = 0; k < std::min(left, a_round) && rr > 1e-24 * first; ++k) {
      const Vectors a_p = multiply(system, p);
      const double alpha = rr / dot(p, a_p);
      for (std::size_t i = 0; i < u.size(); ++i) {
        u[i] += alpha * p[i];
        r[i] -= alpha * a_p[i];
      }
      const double next = dot(r, r);
      for (std::size_t i = 0; i < u.size(); ++i) p[i] = r[i] + next / rr * p[i];
      rr = next;
    }
  }
  return u;
}

}  // namespace tactile_clay::clay
