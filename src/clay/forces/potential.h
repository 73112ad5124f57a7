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

/// Internal forces of the clay in a time step. They are linearised once, at its start. Iterations do not
/// change the linearisation, only the Compression.
///
/// The three internal constraint families of the paper are written as energies of the displacements u of the
/// step. A constraint with a compliance is equivalent to its energy (XPBD, Macklin et al. 2016). With l_ij
/// the length of a pair and r_ij its length at the start of the step, the energies are:
///  - density (Macklin & Mueller 2013), one-sided: kappa/2 V C_i^2 where C_i = rho_i / rho_0 - 1 > 0;
///    V is smaller where clay starts the step at more than twice rho_0, as in pockets between hands
///    (`boundExcess`);
///  - viscosity (Eq. 3, 4), the strain of the step measured along pairs (Monaghan 2005, Rep. Prog. Phys.
///    68:1703; Weiler et al. 2018): c/2 w r_ij^2 (l_ij - r_ij)^2 / dt, with w of r/h (`dashpotWeight`). A
///    rotation changes no length, so no rotation must be removed. Pairs also damp motions that a gradient
///    summed over neighbours cannot see. c is such that the shear viscosity of each particle's volume,
///    averaged over directions, is eta, also at a surface;
///  - bonds (Eq. 5): k/2 (l_ij - d_ij)^2. Elongations go on flowing as they did after the last step (struct
///    Flow), and between the rounds of a step as they do at its displacements (`Potential::yieldAt`).
/// All forces are sums over pairs, opposite on the two ends and along the pair. So linear and angular
/// momentum are conserved exactly.
///
/// Lengths and densities are exact at the guess, the free displacements, and linear around it, along the
/// directions of the start.
///
/// The forces of density need the pressures of a particle's neighbours. So a force is computed in two halves.
/// The first half runs over all particles and returns the second. A solver can run the second half by ranges,
/// together with its own work on them.
struct StepPotential {
  PairArrays pairs;            // pointers into the neighbourhood and the arrays below
  DensityConstraints density;  // if no material has density, only the ratios are used
  bool excessive = false;      // whether any C_i exceeded its bound (`boundExcess`)
  VectorField start_force;     // N, of each particle at u = 0, without density
  float half_spacing = 0.0f;   // m
  float dt = 0.0f;             // s
  std::vector<float> gradient_x, gradient_y, gradient_z, spring;  // see PairArrays
  Secants secants;

  /// Forces f at the displacements u, N. From here on, density constraints are active where u compresses.
  /// @param at is set to the compression at u
  [[nodiscard]] Pressing startForce(const VectorField& u, VectorField& f, Compression& at) const;
  /// Change of the forces with the displacements p: the linear part of the force, negative semidefinite.
  /// @param at of a force whose second half is done; its growth with p is set
  [[nodiscard]] Pressing startChange(const VectorField& p, VectorField& change, Compression& at) const;
  /// Both in one pass over the pairs.
  [[nodiscard]] Pressing startForceAndChange(const VectorField& u, VectorField& f, const VectorField& p,
                                             VectorField& change, Compression& at) const;

  /// Sets displacements w, m, that undo a part of the compression beyond its bound (`recoverBeyond`).
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

  /// Linearises the potential around the free displacements.
  /// @param contacts in the order of their particles; solids add to the density
  /// @param step is overwritten; its memory is reused
  void linearise(const StepInput& input, const std::vector<Contact>& contacts, StepPotential& step);

  /// Lets bonds yield as the displacements u ask for, instead of as after the last step.
  /// @param contacts as they act at u, in the order of their particles
  /// @param step linearised for this input
  void yieldAt(const VectorField& u, const StepInput& input, const std::vector<Contact>& contacts,
               StepPotential& step);

  /// Density that solids added in the step. Their contacts must remember it.
  const std::vector<BoundaryDensity::Share>& boundaryShares() const { return boundary_.shares(); }

 private:
  void resize(const StepInput& input, StepPotential& step);
  Setup setupOf(const StepInput& input, StepPotential& step);

  Kernel kernel_;
  float spacing_;           // m
  float lattice_sum_;       // 1/m^3
  float lattice_dashpots_;  // m^4
  std::size_t materials_;
  std::vector<float> dashpots_;          // N s/m^3, of a pair of weight 1, for each two materials
  std::vector<float> dashpots_of_step_;  // N/m^3, the same divided by the time step
  std::vector<float> bulks_;             // J, bulk modulus times volume of a particle, of each material
  std::vector<float> flow_indices_;      // of each material
  bool dense_ = false, viscous_ = false, thins_ = false;
  BoundaryDensity boundary_;
  std::vector<float> amend_;  // see Setup
};

}  // namespace tactile_clay::clay
