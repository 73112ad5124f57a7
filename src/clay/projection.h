#pragma once

#include <Eigen/Core>
#include <vector>

#include "clay/bonds.h"
#include "clay/contacts.h"
#include "clay/kernel.h"
#include "clay/material.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"
#include "lanes/lane_matrix.h"

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
  struct alignas(sizeof(Lane)) Viscosity {  // of eight particles
    Symmetric inverse, weight;              // of the gradients
    Symmetric multiplier;                   // kg m^2
    Lane compliance;                        // 1/(kg m^2); negative: none
  };
  /// Ends of bonds as the loops over lanes see them, in the order of the pairs, but without gaps among those
  /// of a particle.
  struct BondEnds {
    std::uint32_t *end, *slot;
    float *x, *y, *z;            // x_i - x_j at the start, m
    float *rest_length, *share;  // m; of the error, what this end moves
  };

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
  /// \param bonds null: there are none
  /// \param free displacements, m, that the particles would make without constraints
  /// \param contacts as detected; gets its states, anchors and forces (Eq. 6 summed over the iterations)
  /// \param u displacements of the step, m
  void solve(const Neighbourhood& near, const Particles& particles, const Bonds* bonds,
             const VectorField& free, int iterations, float dt, Contacts& contacts, VectorField& u);

  /// rho / rho_0 at the start of the step.
  const std::vector<float>& densityRatio() const { return ratio_; }

 private:
  void begin(const Bonds* bonds, const VectorField& free, float dt);
  void beginParticle(std::size_t i, const Bonds* bonds, const VectorField& free, float dt);
  void beginContacts(const std::vector<Contact>& contacts);
  void endContacts(float dt, std::vector<Contact>& contacts) const;

  void projectDensity();
  void projectViscosity();
  void projectBondsAndContacts();
  BondEnds bondEnds() {
    return {bond_end_.data(), bond_slot_.data(),   bond_x_.data(),    bond_y_.data(),
            bond_z_.data(),   rest_length_.data(), bond_share_.data()};
  }

  Kernel kernel_;
  float volume_;                                             // m^3, of a particle
  float lattice_sum_;                                        // 1/m^3
  std::vector<float> viscosity_, friction_, skin_friction_;  // of each material
  std::vector<bool> dense_;                                  // materials that resist compression
  bool any_dense_ = false, viscous_ = false, bonded_ = false;
  const Neighbourhood* near_ = nullptr;
  const Particles* particles_ = nullptr;

  std::vector<float> ratio_;  // rho / rho_0
  VectorField u_, moved_;     // displacements, m; the fourth numbers are inverse masses, 1/kg
  std::vector<float> inverse_mass_;

  // Pairs have the order of the neighbourhood, gradients are eight x, y, z in turn. Arrays of particles have
  // whole lanes.
  std::vector<float> density_gradient_;  // of C_i by x_i, 1/m
  std::vector<float> density_share_;     // of a full correction; 0: does not resist compression
  std::vector<float> density_step_;      // multiplier of this projection, kg m^2
  std::vector<float> gradient_;          // V grad W_ij at the start, 1/m
  VectorField own_gradient_;             // its sum, 1/m
  std::vector<float> compliance_;        // of viscosity, 1/(kg m^2); negative: none
  std::vector<Viscosity> viscosities_;   // of each eight particles
  // Change of the multipliers in this projection, corrected: columns x and y in two slots, z in one.
  std::vector<float> strain_step_xy_, strain_step_z_;

  std::vector<float> bond_relaxation_;  // of each particle
  std::vector<std::uint32_t> bond_end_, bond_slot_;
  std::vector<float> bond_x_, bond_y_, bond_z_, rest_length_, bond_share_;

  std::vector<std::uint32_t> contact_begin_;  // of each particle
  std::vector<Touch> touches_;                // of each contact
};

}  // namespace tactile_clay::clay
