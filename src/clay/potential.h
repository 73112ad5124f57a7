#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "clay/bonds.h"
#include "clay/kernel.h"
#include "clay/material.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"

namespace tactile_clay::clay {

/// Pairs of a step as the vector loops see them. With du = u_j - u_i of a pair, and g along x_i - x_j:
struct PairArrays {
  const std::uint32_t *begin, *end, *slot;  // end: of whole lanes; slot of j
  const float *x, *y, *z;                   // g, 1/m; C_i grows by g . du; without density, the offset, m
  const float* spring;                      // J; the force on i is spring (g . du) g
  bool many;                                // more than the caches hold
};

/// Internal forces of the clay in a time step, linearised once at its start.
///
/// The three internal constraint families of the paper are written as energies of the displacements u of the
/// step; a constraint with compliance and its energy are the same thing (Macklin et al. 2016, XPBD). With the
/// length l_ij of a pair and its length r_ij at the start of the step:
///  - density (Macklin & Mueller 2013), one-sided: kappa/2 V C_i^2 where C_i = rho_i / rho_0 - 1 > 0;
///    V is less where clay starts the step denser than twice, as in pockets between hands (`stiffness`);
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
/// A step that ends far from its guess may leave more compression than its model knew of, which nothing has
/// done work for. So C_i starts with no more than the last step's model ended with; the rest is undone
/// slowly, by displacements that are no motion (`recovery`).
class Potential {
 public:
  Potential(const Kernel& kernel, float spacing, const std::vector<Material>& materials);

  /// Sets up a step. \param guess displacements, m, near which it is linearised; \param bonds null: there are
  /// none
  void begin(const Neighbourhood& near, const Particles& particles, const Bonds* bonds,
             const VectorField& guess, float dt);

  /// Adds to the density of a particle in this step. \param ratio of rho_0
  void addDensity(std::size_t i, float ratio) { ratio_[i] += ratio, excess_[i] += ratio; }

  /// Bounds C_i of particles [first, last) at u = 0 by their compression, and the energy of moving at 0.5
  /// m/s. To be called when all densities have been added. \return whether any C_i is beyond it
  bool limitExcess(std::size_t first, std::size_t last);

  /// Forces at the displacements u, N. Density constraints are active, here and in `change`, where u
  /// compresses.
  void force(const VectorField& u, VectorField& f);
  /// Change of the forces with the displacements p: the linear part of `force`, negative semidefinite.
  void change(const VectorField& p, VectorField& f);

  /// The same in two halves, for particles [first, last), so that a solver can put work of its own beside
  /// them: the second half wants the first of all neighbours to be done. Of the ranges of `startForce`, any
  /// may tell that a density constraint is active; the solver then says so to all.
  bool startForce(const VectorField& u, VectorField& f, std::size_t first, std::size_t last);
  /// `startForce` at u and `startChange` with p, in one pass over the pairs.
  bool startForceAndChange(const VectorField& u, VectorField& f, const VectorField& p, VectorField& change,
                           std::size_t first, std::size_t last);
  void setPressing(bool any) { pressing_ = any; }
  void startChange(const VectorField& p, VectorField& f, std::size_t first, std::size_t last);
  void finishForce(VectorField& f, std::size_t first, std::size_t last);
  void finishForceAndChange(VectorField& f, VectorField& change, std::size_t first, std::size_t last);
  void finishChange(VectorField& f, std::size_t first, std::size_t last) const;

  /// The displacements of particles [first, last) grew by `step` times the p of the last `startChange` or
  /// `startForceAndChange`.
  void follow(float step, std::size_t first, std::size_t last);
  /// C_i where the displacements have come to, if its force acted on the way there; else 0.
  float compression(std::size_t i) const {
    return active_[i] > 0.0f ? std::max(compression_[i], 0.0f) : 0.0f;
  }
  /// What stores the energy of that, without what it was lent, at the stiffness of clay less than twice as
  /// dense as at rest; 1 at most, what clay stores at that density: what hands shut in without any room would
  /// store joules, and throw what slips out.
  float paidCompression(std::size_t i) const {
    const float c = compression(i);
    if (!(c > 0.0f)) return 0.0f;
    const float square = stiffness(i) / bulk_[particles_->material[i]] * std::max(c * c - lent_[i], 0.0f);
    return std::min(std::sqrt(square), 1.0f);
  }

  /// J, of that.
  double storedEnergy(std::size_t i) const {
    const double c = paidCompression(i);
    return 0.5 * bulk_[particles_->material[i]] * c * c;
  }

  /// What the slope of the energies along that p, J, is more than with the set of
  /// active constraints, of particle i, `step` times p further than the displacements have come to.
  double slopeBeyondSet(std::size_t i, float step) const {
    if (!dense_) return 0.0;
    const float c = compression_[i] + step * growth_[i];
    return static_cast<double>((c > 0.0f ? stiffness(i) : 0.0f) - active_[i]) * c * growth_[i];
  }

  /// Displacements, m, that undo some of what `limitExcess` found beyond its bound, at 0.5 m/s and by half
  /// a spacing at most.
  void recovery(float dt, VectorField& w);

  /// Whether there are viscosity or bonds.
  bool sprung() const { return sprung_; }

  /// rho / rho_0 at the start of the step.
  const std::vector<float>& densityRatio() const { return ratio_; }

 private:
  PairArrays pairs() const;
  /// J, bulk modulus times volume. The work of a pressure kappa C on clay whose volume is V / (1 + C) is
  /// kappa V C / (1 + C)^2 dC. So that it is the same for a step, and V up to twice the density, the factor
  /// is (2 / ratio)^2 of the start.
  float stiffness(std::size_t i) const {
    const float share = 2.0f / std::max(ratio_[i], 2.0f);
    return share * share * bulk_[particles_->material[i]];
  }
  void stretch(const VectorField& u, VectorField& f, std::vector<float>& growth, std::size_t first,
               std::size_t last);
  bool addStart(VectorField& f, std::size_t first, std::size_t last);

  Kernel kernel_;
  float volume_;            // m^3, of a particle
  float lattice_sum_;       // 1/m^3
  float lattice_dashpots_;  // m^4
  std::size_t materials_;
  std::vector<float> dashpot_;          // N s/m^3, of a pair where its weight is 1, for each two materials
  std::vector<float> dashpot_of_step_;  // N/m^3, dashpot_ over the step
  std::vector<float> bulk_;             // J, bulk modulus times volume of each material
  std::vector<float> flow_index_;       // of each material
  bool dense_ = false, sprung_ = false, thins_ = false;
  const Neighbourhood* near_ = nullptr;
  const Particles* particles_ = nullptr;

  std::vector<float> x_, y_, z_, spring_;  // see PairArrays; what a scene does not use is empty
  std::vector<float> amend_;        // of the dashpots of each particle for those that a surface takes away
  VectorField force_;               // N, of each particle at u = 0, without density
  std::vector<float> excess_;       // C_i at u = 0
  std::vector<float> beyond_;       // what C_i is more than that
  std::vector<float> lent_;         // of the square of C_i at u = 0, what was not paid for
  std::vector<float> steepness_;    // 1/m, length of the gradient of C_i over its neighbours
  std::vector<float> growth_;       // of C_i with the displacements last asked for
  std::vector<float> compression_;  // C_i at the displacements that were followed
  std::vector<float> ratio_;        // rho_i / rho_0
  std::vector<float> active_;       // J, bulk modulus times volume where the density constraint acts, else 0
  std::vector<float> pressure_;     // J, pressure times volume, or its change
  std::vector<float> pressure_change_;  // J, beside a force
  bool pressing_ = false;               // any is active
  std::vector<std::uint8_t> squeezed_;  // whether a particle or a neighbour of it is
};

}  // namespace tactile_clay::clay
