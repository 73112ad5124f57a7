#pragma once

#include <Eigen/Core>
#include <vector>

#include "clay/contact/contact.h"
#include "clay/kernel.h"
#include "clay/material.h"
#include "clay/paper/projection_loops.h"
#include "clay/solver/step_input.h"

namespace tactile_clay::clay {

/// The paper's own scheme (Algorithm 1), the baseline of every comparison: position based dynamics. In each
/// iteration the constraint types follow each other in the paper's order, and the constraints of one type are
/// projected (Eq. 2) at once, as in Jacobi's method:
///  - density C_i = rho_i / rho_0 - 1 (Macklin & Mueller 2013), at the current positions; one-sided as in
///    Macklin et al. 2014, since bonds hold the clay together;
///  - viscosity C_i = sym(grad v_i) dt (Eq. 3), grad v_i the SPH sum of Eq. 4 over v dt = u - u^r with u^r
///  the
///    rotation of the displacements about i. The sum is corrected to be exact for linear fields (Randles &
///    Libersky 1996), or the constraint would turn the surface. Projected along C_i as a whole, which is Eq.
///    2 for its norm. Its compliance 1 / (2 eta V dt) gives eta its unit; at 0 it is Eq. 3 as printed;
///  - bonds C_ij = |x_i - x_j| - d_ij (Eq. 5), rigid;
///  - impenetrability C = n . u - gap >= 0, and friction: the particle is drawn to its anchor, along the
///    surface, by at most mu times what the impenetrability of the same iteration moved it.
///
/// Constraints of a type overlap, so their corrections are under-relaxed, by one factor for all particles of
/// a constraint: what is equal and opposite stays so, linear momentum is exact, and the sum of Eq. 6 is the
/// true contact force. Sums are formed in gather order: the same bits for any number of threads.
///
/// What the paper lacks is not here either: adhesion, and a compliance of bonds and density.
class Projection {
 public:
  /// A contact as the iterations see it.
  struct Touch {
    std::uint32_t particle;
    float gap;                       // m
    Eigen::Vector3f normal, anchor;  // anchor: m, from the particle before the step
    float friction;                  // coefficient
    float pushed;                    // m, along the normal by all iterations
    Eigen::Vector3f pulled;          // m, along the surface
  };

  Projection(const Kernel& kernel, float spacing, const std::vector<Material>& materials);

  /// One step.
  /// @param contacts as detected
  /// @param u gets the displacements of the step, m
  /// @return the contacts with their states, anchors and forces (Eq. 6 summed over the iterations)
  std::vector<Contact> solve(const StepInput& input, int iterations, const std::vector<Contact>& contacts,
                             VectorField& u);

  /// rho / rho_0 at the start of the step.
  const std::vector<float>& densityRatio() const { return ratio_; }

 private:
  void begin(const StepInput& input);
  void beginParticle(const StepInput& input, std::size_t i);
  void beginContacts(const Particles& particles, const std::vector<Contact>& contacts);
  void endContacts(const StepInput& input, std::vector<Contact>& contacts) const;

  void projectDensity();
  void projectViscosity();
  void projectBondsAndContacts();
  paper::Densities densities() {
    return {kernel_,
            lattice_sum_,
            inverse_mass_.data(),
            density_share_.data(),
            density_gradient_.data(),
            density_step_.data()};
  }
  paper::Strains strains() {
    return {kernel_,
            volume_,
            inverse_mass_.data(),
            compliance_.data(),
            gradient_.data(),
            own_gradient_.data(),
            viscosities_.data(),
            strain_step_xy_.data(),
            strain_step_z_.data()};
  }
  paper::BondEnds bondEnds() {
    return {bond_end_.data(), bond_slot_.data(),   bond_x_.data(),    bond_y_.data(),
            bond_z_.data(),   rest_length_.data(), bond_share_.data()};
  }

  Kernel kernel_;
  float volume_;                                             // m^3, of a particle
  float lattice_sum_;                                        // 1/m^3
  std::vector<float> viscosity_, friction_, skin_friction_;  // of each material
  std::vector<bool> dense_;                                  // materials that resist compression
  bool any_dense_ = false, viscous_ = false, bonded_ = false;
  paper::Pairs pairs_{};  // of the step

  std::vector<float> ratio_;  // rho / rho_0
  VectorField u_, moved_;     // displacements, m; the fourth numbers are inverse masses, 1/kg
  std::vector<float> inverse_mass_;

  // Arrays of particles have whole lanes.
  std::vector<float> density_gradient_, density_share_, density_step_;         // see paper::Densities
  std::vector<float> gradient_, compliance_, strain_step_xy_, strain_step_z_;  // see paper::Strains
  VectorField own_gradient_;
  std::vector<paper::Viscosity> viscosities_;

  std::vector<float> bond_relaxation_;  // of each particle
  std::vector<std::uint32_t> bond_end_, bond_slot_;
  std::vector<float> bond_x_, bond_y_, bond_z_, rest_length_, bond_share_;

  std::vector<std::uint32_t> contact_begin_;  // of each particle
  std::vector<Touch> touches_;                // of each contact
};

}  // namespace tactile_clay::clay
