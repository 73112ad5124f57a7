#pragma once

#include <vector>

#include "clay/contact/contact.h"
#include "clay/forces/boundary_density.h"
#include "clay/forces/density.h"
#include "clay/forces/linearise.h"
#include "clay/forces/pair_loops.h"
#include "clay/kernel.h"
#include "clay/material.h"
#include "clay/solver/step_input.h"
#include "clay/vector_field.h"

namespace tactile_clay::clay {

/// Internal forces of the clay in a time step, linearised once at its start and the same from then on.
///
/// The three internal constraint families of the paper are written as energies of the displacements u of the
/// step; a constraint with compliance and its energy are the same thing (Macklin et al. 2016, XPBD). With the
/// length l_ij of a pair and its length r_ij at the start of the step:
///  - density (Macklin & Mueller 2013), one-sided: kappa/2 V C_i^2 where C_i = rho_i / rho_0 - 1 > 0;
///    V is less where clay starts the step denser than twice, as in pockets between hands (`boundExcess`);
///  - viscosity (Eq. 3, 4), the strain of the step measured along pairs (Monaghan 2005, Rep. Prog. Phys.
///    68:1703; Weiler et al. 2018): c/2 (1 - (r/h)^2)^3 r_ij^2 (l_ij - r_ij)^2 / dt. Rotation changes no
///    length, so none need be turned back, and pairs see the motions that a gradient summed over neighbours
///    is blind to. c makes the shear viscosity of each particle's volume, averaged over directions, equal to
///    eta, at a surface too;
///  - bonds (Eq. 5): k/2 (l_ij - d_ij)^2, where elongations go on flowing as they did after the last
///    step (struct Flow).
/// All are sums over pairs with opposite forces along the pair on its two ends, so linear and angular
/// momentum are exact.
///
/// Lengths and densities are exact at the guess and linear around it, with the directions of the start.
///
/// The forces of density need the pressures of a particle's neighbours. So a force has two halves: the first
/// is of all particles, and returns the second, which a solver can do by ranges beside work of its own.
struct StepPotential {
  PairArrays pairs;            // of the neighbourhood, and of the arrays below
  DensityConstraints density;  // without density, of its numbers only the ratios
  bool excessive = false;      // whether any C_i is beyond what may push
  VectorField start_force;     // N, of each particle at u = 0, without density
  float half_spacing = 0.0f;   // m
  float dt = 0.0f;             // s
  std::vector<float> gradient_x, gradient_y, gradient_z, spring;  // see PairArrays

  /// Forces f at the displacements u, N. Density constraints are active, from here on, where u compresses.
  /// @param at gets what they are at u
  [[nodiscard]] Pressing startForce(const VectorField& u, VectorField& f, Compression& at) const;
  /// Change of the forces with the displacements p: the linear part of the force, negative semidefinite.
  /// @param at of a force that is complete; gets the growth with p
  [[nodiscard]] Pressing startChange(const VectorField& p, VectorField& change, Compression& at) const;
  /// Both in one pass over the pairs.
  [[nodiscard]] Pressing startForceAndChange(const VectorField& u, VectorField& f, const VectorField& p,
                                             VectorField& change, Compression& at) const;

  /// Displacements w, m, that undo some of what is beyond (`recoverBeyond`).
  /// @param used is overwritten
  void recover(Compression& used, VectorField& w) const {
    recoverBeyond(pairs, density, half_spacing, dt, used, w);
  }

 private:
  bool addStart(VectorField& f, Compression& at, std::size_t first, std::size_t last) const;
};

/// Sets up the potential of each step for the clay's materials.
class Potential {
 public:
  Potential(const Kernel& kernel, float spacing, const std::vector<Material>& materials);

  /// Linearises it near the free displacements.
  /// @param contacts by particle; solids add to the density
  /// @param step is overwritten, but for its memory
  void linearise(const StepInput& input, const std::vector<Contact>& contacts, StepPotential& step);

  /// What solids added to the density of the step, for their contacts to remember.
  const std::vector<BoundaryDensity::Share>& boundaryShares() const { return boundary_.shares(); }

 private:
  void resize(const StepInput& input, StepPotential& step);
  Setup setupOf(const StepInput& input, StepPotential& step);

  Kernel kernel_;
  float spacing_;           // m
  float lattice_sum_;       // 1/m^3
  float lattice_dashpots_;  // m^4
  std::size_t materials_;
  std::vector<float> dashpots_;          // N s/m^3, of a pair where its weight is 1, for each two materials
  std::vector<float> dashpots_of_step_;  // N/m^3, the same over the step
  std::vector<float> bulks_;             // J, bulk modulus times volume of each material
  std::vector<float> flow_indices_;      // of each material
  bool dense_ = false, viscous_ = false, thins_ = false;
  BoundaryDensity boundary_;
  std::vector<float> amend_;  // see Setup
};

}  // namespace tactile_clay::clay
