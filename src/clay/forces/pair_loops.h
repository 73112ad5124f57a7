#pragma once

#include <cstddef>
#include <cstdint>

#include "clay/neighbourhood.h"

namespace tactile_clay::clay {

/// Pairs of a step as the vector loops see them. With du = u_j - u_i of a pair, C_i grows by g . du: g, 1/m,
/// is along x_i - x_j and stands for it in `x`, `y`, `z`, if there is density.
struct PairArrays : NeighbourPairs {
  const float* spring;  // J; the force on i is spring (g . du) g
  bool dense, sprung;   // whether there is density, and viscosity or bonds
  bool many;            // more than the caches hold
};

/// Displacements, and what they do to the particles: forces of the springs, N, and growth of C.
struct Stretch {
  const float* u;
  float *f, *growth;
};

/// Sets forces, and growth where there is density, of particles [first, last).
void stretchPairs(const PairArrays& pairs, const Stretch& one, std::size_t first, std::size_t last);
/// The same for two displacements. Where there are many pairs, it is reading them that takes the time.
void stretchPairs(const PairArrays& pairs, const Stretch& one, const Stretch& other, std::size_t first,
                  std::size_t last);

/// Pressures times volume, J, of all particles, and the forces that they are added to.
struct Press {
  const float* pressure;
  float* f;
};

/// The second half of forces on the clay: what is left to do once the pressures of all particles are known.
/// Particles that no pressure is at, nor beside, are passed over: the first that adds forces finds which.
struct Pressing {
  PairArrays pairs;
  Press one, other;        // other: beside the first, or all null
  std::uint8_t* squeezed;  // of each particle: whether it, or a neighbour of it, has a pressure in `one`
  bool finds;              // those, or has them from one that did
  bool any;                // whether there are any pressures

  /// Adds the forces of particles [first, last), sum_j (P_i + P_j) g.
  void add(std::size_t first, std::size_t last) const;
};

}  // namespace tactile_clay::clay
