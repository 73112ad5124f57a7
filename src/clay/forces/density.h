#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "clay/forces/pair_loops.h"
#include "clay/particles.h"
#include "clay/vector_field.h"

namespace tactile_clay::clay {

/// The one-sided density constraint of each particle in a step. C_i is `excess` plus the change by
/// displacements. While C_i is positive, its energy is `stiffness`/2 C_i^2.
///
/// A step that ends far from its guess may leave more compression than its linear model had. Nothing has done
/// work for this part. So C_i starts with at most the compression at the end of the last step's model, plus a
/// loan. Only a small part of the loan is kept for the next step (`boundExcess`). Compression beyond both is
/// undone slowly, by displacements that do not count as motion (`recoverBeyond`).
struct DensityConstraints {
  std::vector<float> ratio;      // rho_i / rho_0 at the start of the step
  std::vector<float> bulk;       // J, bulk modulus times volume
  std::vector<float> stiffness;  // J, `bulk`, reduced for clay denser than twice rho_0
  std::vector<float> excess;     // C_i at u = 0, bounded
  std::vector<float> lent;       // part of the square of `excess` that is lent and not kept
  std::vector<float> beyond;     // compression that is cut off from `excess`
  std::vector<float> steepness;  // 1/m, length of the gradient of C_i over its neighbours
};

/// State of the density constraint of each particle in an iteration.
struct Compression {
  std::vector<float> c;                          // C_i at the displacements u
  std::vector<float> active;                     // J, stiffness if the constraint acts at u, else 0
  std::vector<float> growth;                     // change of C_i with the direction p
  std::vector<float> pressure, pressure_change;  // J, pressure times volume at u; its change with p
  std::vector<std::uint8_t> squeezed;            // see Pressing
  bool pressing = false;                         // whether any constraint is active

  void resize(std::size_t n);
  /// Determines which constraints of particles [first, last) are active, and their pressures. Before the call
  /// `c` is the change by u alone; the call makes it C_i.
  /// @return whether any constraint is active
  bool activate(const DensityConstraints& of, std::size_t first, std::size_t last);
  /// Sets the change of their pressures with p.
  void changePressure(std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) pressure_change[i] = active[i] * growth[i];
  }
  /// Updates C_i, because u of particles [first, last) has become u + step p.
  void follow(float step, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) c[i] += step * growth[i];
  }
  /// C_i, if its constraint is active and C_i is still positive; else 0.
  float acting(std::size_t i) const { return active[i] > 0.0f && c[i] > 0.0f ? c[i] : 0.0f; }
};

/// Sets the stiffness of particles [first, last), bounds their excess by `Particles::compression` and the
/// loan, and moves the rest to `beyond`.
/// @return whether any particle has such a rest
bool boundExcess(const Particles& particles, std::size_t first, std::size_t last, DensityConstraints& of);

/// Compression that stores the energy of C_i, without the loan, at the stiffness `bulk`. At most 1, the
/// compression at twice the density: otherwise clay that hands enclose without any room would store joules,
/// and be thrown when it slips out.
float paidCompression(const DensityConstraints& of, const Compression& compression, std::size_t i);
/// Energy of the paid compression, J.
double storedEnergy(const DensityConstraints& of, const Compression& compression, std::size_t i);

/// Slope of the energy of particle i along p at u + step p, minus the slope with the present set of active
/// constraints, J.
double slopeBeyondSet(const DensityConstraints& of, const Compression& compression, std::size_t i,
                      float step);

/// Sets displacements w, m, that undo a part of `beyond`. Each constraint is undone at 0.5 m/s and by half a
/// spacing at most; no particle moves by more than twice that.
/// @param farthest m, half a spacing
/// @param used its pressures are overwritten
void recoverBeyond(const PairArrays& pairs, const DensityConstraints& of, float farthest, float dt,
                   Compression& used, VectorField& w);

}  // namespace tactile_clay::clay
