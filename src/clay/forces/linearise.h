#pragma once

#include <cstddef>
#include <cstdint>

#include "clay/forces/bonds.h"
#include "clay/kernel.h"
#include "clay/neighbourhood.h"

namespace tactile_clay::clay {

/// What the potential of a step is set up from and in, as the vector loops see it; null: not in this scene.
struct Setup {
  NeighbourPairs pairs;          // at the start of the step
  const float* guess;            // m, slots: displacements near which it is linearised
  const std::uint8_t* material;  // of each particle
  std::size_t materials;
  struct Elastic {
    const Bonds* bonds;
    const float* rest_length;  // m, of each pair
    const float* secant;       // of the stiffness of the bonds of each particle, see Flow
  } elastic;
  struct Viscous {
    const float* dashpot;     // N/m^3, of each two materials, where a pair's weight is 1
    const float* flow_index;  // of each material; null: none thins
    float lattice;            // m^4, sum over the initial lattice of the dashpot weight times r^4
    float dt;                 // s
  } viscous;
  Kernel kernel;
  float lattice_sum;   // 1/m^3
  bool dense, sprung;  // whether there is density, and viscosity or bonds
  // Gets set.
  struct OfPairs {  // see PairArrays
    float *x, *y, *z, *spring;
  } of_pairs;
  float *ratio, *steepness, *excess;  // see DensityConstraints
  float* amend;                       // of the dashpots of each particle for those that a surface takes away
  float* force;                       // N, slots, at u = 0 and without density
};

/// Of particles [first, last): densities and their gradients, and how strong dashpots are. To be done for all
/// particles before any is linearised.
void measureSurroundings(const Setup& setup, std::size_t first, std::size_t last);

/// Of particles [first, last): springs of their pairs, forces and densities at u = 0.
void linearisePairs(const Setup& setup, std::size_t first, std::size_t last);

/// m^4, see Setup::Viscous.
double latticeDashpots(const Kernel& kernel, float spacing);

}  // namespace tactile_clay::clay
