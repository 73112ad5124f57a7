#pragma once

#include <cstddef>
#include <vector>

#include "clay/contact/contact.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"
#include "clay/vector_field.h"

namespace tactile_clay::clay {

class Bonds;
struct StepInput;

/// Strain tensors of particles.
struct StrainField {
  VectorField normal;  // xx, yy, zz
  VectorField shear;   // yz, zx, xy
};

/// How the bonds of each particle flow. The stress at the particle decides, not the strain of a bond (von
/// Mises).
///
/// The bonds of a particle of volume V give it the stress sigma = 1/(2 V) sum_j k (l - d) l n n^T, with d the
/// rest length and n the direction of a bond. The factor 1/2 is there because a bond belongs half to each
/// end. Let s be the deviator of sigma. If |s| = sqrt(s:s / 2) is above the yield stress tau_y, the
/// elongations l - d shrink to `share` = tau_y / |s| of themselves, all but those of the strain of their
/// volume, `volume` (radial return). The stress that is left lies on the yield surface. Stresses that balance
/// among the bonds fade with the flow. A change of volume is never forgotten, so flow keeps volume. A bond
/// takes the mean of what its two ends leave.
///
/// If the material has a relaxation time t_r, stress below the yield fades, too (Maxwell): in a time t,
/// `share` is multiplied by exp(-t / t_r).
///
/// A collider adds to the stress of a particle that it touches: spacing/(2 V) (f n^T + n f^T + N n n^T). Here
/// n is the normal of the collider, N the pull of the bonds along n, if it presses on the collider, and f
/// their pull along the surface, at most the friction of the last step. So clay at a wall yields as in its
/// inside.
///
/// Worked clay has more bonds than the initial lattice: their sum k l^2 is up to 2.6 times as large. At a
/// surface this sum is smaller. The amount of clay is the same. So the bonds of a particle are
/// softened by the factor by which their sum is too large, or stiffened by the root of the factor by which it
/// is too small. It is the root because only half of the bonds that a surface takes away matters: no stress
/// crosses a free surface. The bonds are stiffened at most as those of a flat surface. A bar then has the
/// Young's modulus of the material, within 2 % from six columns on. The sum uses rest lengths, so
/// it changes only with bonds and flow. When it changes, a bond that gets stiffer keeps its force, and a bond
/// that gets softer keeps its elongation: neither gains energy.
struct Flow {
  std::vector<float> share;      // of the elongations that is kept; 1: no flow
  std::vector<float> stiffness;  // of the bonds of a particle, over that of their BondRule
  std::vector<float> before;     // the stiffness before bonds formed or broke in this update
  std::vector<float> secant;     // stiffness times share, see `linearisePairs`
  StrainField volume;            // the strain that flow keeps; 0 of particles that do not flow
  std::vector<float> kept;  // of each material: share of the stress that relaxation leaves, exp(-t / t_r)

  void resize(std::size_t particles);
};

/// Stiffness of the bonds of a particle over that of their BondRule.
/// @param squares sum of the squares of their rest lengths, in spacings^2
float bondStiffness(float squares);

/// Measures share, secant and volume of particles [first, last). Needs the rest lengths of the bonds and
/// the other numbers of `flow` of all particles.
/// @param contacts in the order of their particles
void measureFlow(const Neighbourhood& near, const Particles& particles, const Bonds& bonds,
                 const std::vector<Contact>& contacts, std::size_t first, std::size_t last, Flow& flow);

/// Factors of the stiffness of each particle's bonds within a step.
struct Secants {
  std::vector<float> value;   // see Flow; empty: there are no bonds
  std::vector<float> change;  // by the last `measureSecants`
};

/// Measures the secants of particles [first, last) where the displacements u of a step take them.
/// @param contacts in the order of their particles
void measureSecants(const StepInput& input, const std::vector<Contact>& contacts, const VectorField& u,
                    std::size_t first, std::size_t last, Secants& secants);

}  // namespace tactile_clay::clay
