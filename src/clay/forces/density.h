#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "clay/forces/pair_loops.h"
#include "clay/particles.h"
#include "clay/vector_field.h"

namespace tactile_clay::clay {

/// Density's one-sided constraints in a step, of each particle: C_i is `excess` and what displacements add to
/// it, with the energy `stiffness`/2 C_i^2 where it is positive.
///
/// A step that ends far from its guess may leave more compression than its model knew of, which nothing has
/// done work for. So C_i starts with no more than the last step's model ended with, and a loan; the loan is
/// not kept, and what is beyond is undone slowly, by displacements that are no motion (`recoverBeyond`).
struct DensityConstraints {
  std::vector<float> ratio;      // rho_i / rho_0 at the start of the step
  std::vector<float> bulk;       // J, bulk modulus times volume
  std::vector<float> stiffness;  // J, the same for the work of compressing what is denser than twice
  std::vector<float> excess;     // C_i at u = 0
  std::vector<float> lent;       // of its square, what was not paid for
  std::vector<float> beyond;     // what C_i was more than that
  std::vector<float> steepness;  // 1/m, length of the gradient of C_i over its neighbours
};

/// Where the density constraints have come to in an iteration, of each particle.
struct Compression {
  std::vector<float> c;                          // C_i at the displacements u
  std::vector<float> active;                     // J, stiffness where the constraint acts there, else 0
  std::vector<float> growth;                     // of C_i with the direction p
  std::vector<float> pressure, pressure_change;  // J, times volume, at u, and its change with p
  std::vector<std::uint8_t> squeezed;            // see Pressing
  bool pressing = false;                         // whether any is active

  void resize(std::size_t n);
  /// Tells which constraints of particles [first, last) are active, and their pressures. Before, `at` is what
  /// u alone adds up to; after, C_i.
  /// @return whether any is active
  bool activate(const DensityConstraints& of, std::size_t first, std::size_t last);
  /// Sets the change of their pressures with p.
  void changePressure(std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) pressure_change[i] = active[i] * growth[i];
  }
  /// u of particles [first, last) has become u + step p.
  void follow(float step, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) c[i] += step * growth[i];
  }
  /// C_i, if its force acted on the way there; else 0.
  float acting(std::size_t i) const { return active[i] > 0.0f && c[i] > 0.0f ? c[i] : 0.0f; }
};

/// Sets the stiffness of particles [first, last), bounds their excess by `Particles::compression` and what is
/// lent, and sets aside what is beyond.
/// @return whether any is
bool boundExcess(const Particles& particles, std::size_t first, std::size_t last, DensityConstraints& of);

/// What stores the energy of C_i, without what it was lent, at the stiffness of clay less than twice as dense
/// as at rest; 1 at most, what clay stores at that density: what hands shut in without any room would store
/// joules, and throw what slips out.
float paidCompression(const DensityConstraints& of, const Compression& compression, std::size_t i);
/// J, of that.
double storedEnergy(const DensityConstraints& of, const Compression& compression, std::size_t i);

/// J, what the slope of the energy of particle i along p is more than with the set of active constraints,
/// `step` times p beyond u.
double slopeBeyondSet(const DensityConstraints& of, const Compression& compression, std::size_t i,
                      float step);

/// Displacements w, m, that undo some of what is beyond, at 0.5 m/s and by half a spacing at most.
/// @param farthest m, half a spacing
/// @param used its pressures are overwritten
void recoverBeyond(const PairArrays& pairs, const DensityConstraints& of, float farthest, float dt,
                   Compression& used, VectorField& w);

}  // namespace tactile_clay::clay
