#pragma once

#include <cstddef>
#include <cstdint>

#include "clay/kernel.h"
#include "clay/neighbourhood.h"
#include "lanes/lane_matrix.h"

/// The loops of the paper's scheme over pairs. They get their inputs by value, so that no store can change
/// these.
namespace tactile_clay::clay::paper {

using Pairs = NeighbourPairs;  // at the start of the step

/// Density constraints. Gradients of pairs are stored as eight x, eight y and eight z in turn.
struct Densities {
  Kernel kernel;
  float lattice_sum;          // 1/m^3
  const float* inverse_mass;  // 1/kg, of each particle
  const float* share;         // of a full correction, of each particle; 0: no resistance to compression
  float* gradient;            // of C_i by x_i, of each pair, 1/m
  float* step;                // multiplier of this projection, of each particle, kg m^2
};
/// Sets rho / rho_0 of particles [first, last) at the start of the step.
void measureRatios(Pairs pairs, const Kernel& kernel, float lattice_sum, std::size_t first, std::size_t last,
                   float* ratio);
/// Measures C_i at the displacements u; sets its gradients and the steps of the multipliers.
/// @param u its fourth numbers are inverse masses
void measureDensities(Pairs pairs, Densities densities, const float* u, std::size_t first, std::size_t last);
/// u_i += w_i sum_j (step_i + step_j) gradient_ij
void moveByDensities(Pairs pairs, Densities densities, std::size_t first, std::size_t last, float* u);

/// Viscosity constraints of eight particles.
struct alignas(sizeof(Lane)) Viscosity {
  Symmetric inverse;     // correction of the gradients g
  Symmetric weight;      // sum of inverse mass times g' g'^T, g' = inverse g, the own particle's included
  Symmetric multiplier;  // kg m^2
  Lane compliance;       // 1/(kg m^2); negative: no constraint
};
struct Strains {
  Kernel kernel;
  float volume;                    // m^3, of a particle
  const float* inverse_mass;       // 1/kg, of each particle
  const float* compliance;         // 1/(kg m^2), of each particle; negative: no constraint
  float *gradient, *own_gradient;  // V grad W_ij of each pair at the start; its sums, slots, 1/m
  Viscosity* viscosities;          // one per eight particles
  float *step_xy, *step_z;  // change of a multiplier, corrected: columns x and y in two slots, z in one
};
/// Prepares the constraints of particles [first, last), eight at a time.
void beginStrains(Pairs pairs, Strains strains, std::size_t first, std::size_t last);
/// Sets the steps of the multipliers at the displacements u.
void measureStrains(Pairs pairs, Strains strains, const float* u, std::size_t first, std::size_t last);
/// u_i -= w_i sum_j (S_i + S_j) (V grad W)
void moveByStrains(Pairs pairs, Strains strains, std::size_t first, std::size_t last, float* u);

/// Ends of bonds, in the order of the pairs. The ends of one particle have no gaps between them.
struct BondEnds {
  std::uint32_t *end, *slot;
  float *x, *y, *z;            // x_i - x_j at the start, m
  float *rest_length, *share;  // m; share of the error that this end moves
};
/// @param rest_length of each pair, m; 0: not bonded
/// @param relaxation of the bonds of each particle
void listBonds(Pairs pairs, const float* rest_length, const float* relaxation, const float* inverse_mass,
               std::size_t first, std::size_t last, BondEnds ends);
/// moved_i = u_i - sum_j share (l_ij - d_ij) n_ij
void pullEnds(const std::uint32_t* begin, BondEnds ends, const float* u, std::size_t first, std::size_t last,
              float* moved);

}  // namespace tactile_clay::clay::paper
