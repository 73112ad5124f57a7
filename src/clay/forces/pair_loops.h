#pragma once

#include <cstddef>
#include <cstdint>

#include "clay/neighbourhood.h"

namespace tactile_clay::clay {

/// Pairs of a step, as arrays for the vector loops. With du = u_j - u_i of a pair, C_i grows by g . du. The
/// gradient g, 1/m, is parallel to x_i - x_j. If there is density, `x`, `y`, `z` contain g instead of
/// x_i - x_j.
struct PairArrays : NeighbourPairs {
  const float* spring;  // J; the force on i is spring (g . du) g
  bool dense, sprung;   // whether there is density; whether viscosity or bonds
  bool many;            // whether there are more pairs than fit into the caches
};

/// Displacements u, and their effects on the particles: forces f of the springs, N, and growth of C.
struct Stretch {
  const float* u;
  float *f, *growth;
};

/// Sets the forces on particles [first, last) and, if there is density, the growth of their C.
void stretchPairs(const PairArrays& pairs, const Stretch& one, std::size_t first, std::size_t last);
/// The same for two displacements in one pass, because with many pairs most time is spent on reading them.
void stretchPairs(const PairArrays& pairs, const Stretch& one, const Stretch& other, std::size_t first,
                  std::size_t last);

/// Pressures times volume, J, of all particles, and the forces to which theirs are added.
struct Press {
  const float* pressure;
  float* f;
};

/// The second half of the computation of forces, possible once the pressures of all particles are known. A
/// particle is skipped if neither it nor a neighbour has a pressure. A Pressing with `finds` determines which
/// particles these are.
struct Pressing {
  PairArrays pairs;
  Press one, other;        // other: a second set of pressures, or all null
  std::uint8_t* squeezed;  // of each particle: whether it, or a neighbour of it, has a pressure in `one`
  bool finds;              // whether it sets `squeezed`; else an earlier one has set it
  bool any;                // whether there are any pressures

  /// Adds the forces of particles [first, last), sum_j (P_i + P_j) g.
  void add(std::size_t first, std::size_t last) const;
};

}  // namespace tactile_clay::clay
