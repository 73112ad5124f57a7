#pragma once

#include <Eigen/Core>
#include <vector>

#include "clay/bonds.h"
#include "clay/kernel.h"
#include "clay/material.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"

namespace tactile_clay::clay {

/// Internal forces of the clay in a time step, linearised once at its start.
///
/// The three internal constraint families of the paper are written as energies of the displacements u of the
/// step; a constraint with compliance and its energy are the same thing (Macklin et al. 2016, XPBD):
///  - density (Macklin & Mueller 2013), one-sided: kappa/2 V C_i^2 where C_i = rho_i / rho_0 - 1 > 0;
///  - viscosity (Eq. 3, 4): eta V / dt |E_i|^2 with E = sym(R^T (I + grad u)) - I, the strain of the
///  corotational
///    displacement: a Newtonian fluid of viscosity eta. The SPH gradient is corrected to be exact for linear
///    fields (Randles & Libersky 1996), without which the surface of a rotating body would be braked;
///  - bonds (Eq. 5): k/2 (l_ij - d_ij)^2.
/// All are sums over pairs with opposite forces on the two ends, so linear momentum is exact.
///
/// All terms share one pair loop. With p_ij = V grad W_ij and the plain gradient D_i = sum_j (u_j - u_i)
/// p_ij^T, C_i depends on tr D_i and E_i on D_i L_i, L_i being the correction. The force is f_i = sum_j (S_i
/// + S_j) p_ij with one stress S of each particle, plus that of the bonds.
class Potential {
 public:
  Potential(const Kernel& kernel, float spacing, const std::vector<Material>& materials);

  /// Sets up a step. \param guess displacements, m, near which it is linearised; \param bonds null: there are
  /// none
  void begin(const Neighbourhood& near, const Particles& particles, const Bonds* bonds,
             const VectorField& guess, float dt);

  /// Forces at the displacements u, N. Density constraints are active, here and in `change`, where u
  /// compresses.
  void force(const VectorField& u, VectorField& f) { evaluate<true>(u, f); }
  /// Change of the forces with the displacements p: the linear part of `force`, negative semidefinite.
  void change(const VectorField& p, VectorField& f) { evaluate<false>(p, f); }

  /// rho / rho_0 at the start of the step.
  const std::vector<float>& densityRatio() const { return ratio_; }

 private:
  template <bool affine>
  void evaluate(const VectorField& u, VectorField& f);
  template <bool affine>
  void gatherStress(const VectorField& u, std::size_t i, VectorField& f);
  void gatherForce(std::size_t i, VectorField& f) const;
  void layOutSprings(const Bonds* bonds, std::size_t n);
  void beginKernels(const Particles& particles, std::size_t i);
  void beginSprings(const Particles& particles, const Bonds& bonds, std::size_t i);
  void beginViscosity(const Particles& particles, const VectorField& guess, std::size_t i, float dt);
  Eigen::Matrix3f plainGradient(const VectorField& u, std::size_t i) const;

  Kernel kernel_;
  float volume_;       // m^3, of a particle
  float lattice_sum_;  // 1/m^3
  const std::vector<Material>* materials_;
  bool viscous_ = false;
  const Neighbourhood* near_ = nullptr;

  VectorField gradient_;      // p_ij of each pair, m^2
  VectorField own_gradient_;  // sum of a particle's p_ij
  std::vector<std::uint32_t> spring_begin_, spring_other_;
  VectorField spring_;                    // of each bond at both ends: force = s (s . (u_j - u_i)), sqrt(N/m)
  VectorField bond_force_;                // N, at u = 0
  std::vector<float> ratio_;              // rho / rho_0
  std::vector<float> bulk_;               // Pa, bulk modulus of each particle's material
  std::vector<float> pressing_;           // Pa, the same where the density constraint is active, else 0
  std::vector<float> viscous_stiffness_;  // 2 eta V / dt, J
  std::vector<Eigen::Matrix3f> rotation_, correction_;
  struct Stress {
    Eigen::Vector4f column[3];  // J
  };
  std::vector<Stress> stress_;  // S of each particle
};

}  // namespace tactile_clay::clay
