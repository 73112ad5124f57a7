#pragma once

#include <cstddef>
#include <cstdint>

#include "clay/forces/bonds.h"
#include "clay/kernel.h"
#include "clay/neighbourhood.h"

namespace tactile_clay::clay {

/// Inputs and outputs for setting up the potential of a step, as arrays for the vector loops. A null pointer:
/// the scene does not have this.
struct Setup {
  NeighbourPairs pairs;          // at the start of the step
  const float* guess;            // m, slots: displacements near which the potential is linearised
  const std::uint8_t* material;  // of each particle
  std::size_t materials;
  struct Elastic {
    const Bonds* bonds;
    const float* rest_length;  // m, of each pair
    const float* secant;       // factor of the stiffness of each particle's bonds, see Flow
    const float* change;       // of the secant, for `changeSecants`
  } elastic;
  struct Viscous {
    bool any;                 // whether a material is viscous
    const float* dashpot;     // N/m^3, for each two materials, of a pair with weight 1
    const float* flow_index;  // of each material; null: no material thins
    float lattice;            // m^4, sum over the initial lattice of the dashpot weight times r^4
    float dt;                 // s
  } viscous;
  Kernel kernel;
  float lattice_sum;   // 1/m^3
  bool dense, sprung;  // whether there is density; whether viscosity or bonds
  // Outputs.
  struct OfPairs {  // see PairArrays
    float *x, *y, *z, *spring;
  } of_pairs;
  float *ratio, *steepness, *excess;  // see DensityConstraints
  float* amend;                       // factor of each particle's dashpots, for the surface and for thinning
  float* force;                       // N, slots, at u = 0 and without density
};

/// Measures densities, their gradients and the strength of dashpots of particles [first, last). To be done
/// for all particles before any is linearised.
void measureSurroundings(const Setup& setup, std::size_t first, std::size_t last);

/// Sets the springs of the pairs of particles [first, last), and their forces and densities at u = 0.
void linearisePairs(const Setup& setup, std::size_t first, std::size_t last);

/// Changes the springs of the bonds of particles [first, last), and their forces at u = 0, by the change of
/// the secants.
void changeSecants(const Setup& setup, std::size_t first, std::size_t last);

/// The number `lattice` of Setup::Viscous, m^4.
double latticeDashpots(const Kernel& kernel, float spacing);

}  // namespace tactile_clay::clay
