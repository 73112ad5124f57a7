#pragma once

#include <cstddef>
#include <vector>

#include "clay/contact/contact.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"

namespace tactile_clay::clay {

class Bonds;

/// How the bonds of each particle flow: by the stress at the particle, not by their own strain (von Mises).
///
/// Its bonds give a particle of volume V the stress sigma = 1/(2 V) sum_j k (l - d) l n n^T, n their
/// directions, since half of each bond is its own. Where the deviator s of that is beyond the yield stress,
/// |s| = sqrt(s:s / 2) > tau_y, the elongations l - d shrink to `share` = tau_y / |s| of themselves, all but
/// the strain of their volume, `dilation`: radial return. What is left of them is a stress on the yield
/// surface; stresses that bonds have among themselves fade with the flow; and a change of volume is never
/// forgotten, so flow keeps volume. A bond takes the mean of its two ends.
///
/// Where the material has a relaxation time t_r, stress fades below the yield, too (Maxwell): `share` is less
/// by exp(-t / t_r) in a time t.
///
/// What a collider holds a particle with counts beside its bonds, as a pull f at half a spacing along the
/// normal n: -1/(2 V) d/2 (f n^T + n f^T). So clay that sticks to a wall yields there as in its inside. f is
/// what the bonds pull with along the collider, and at most the friction of the last step.
///
/// Worked clay has more bonds than the initial lattice, up to 2.6 times their sum k l^2, and a particle at a
/// surface has less of that, but no more or less clay. So the bonds of a particle are softer by what they
/// have too much, and stiffer by the root of what they lack: of the bonds that a surface takes away half
/// matters, since no stress crosses a free surface. They are stiffer by what a flat surface takes at most. A
/// bar then has the Young's modulus of the material, within 2 % from six columns on. It is their rest lengths
/// that count, so that this changes only with bonds and flow. Where it does, a bond that gets stiffer keeps
/// its force, one that gets softer its elongation: neither gains energy.
struct Flow {
  std::vector<float> share;      // of the elongations; 1: does not flow
  std::vector<float> stiffness;  // of its bonds, over that of their rule
  std::vector<float> before;     // that of the bonds that were there before any formed or broke
  std::vector<float> secant;     // stiffness times share, see Potential
  std::vector<float> dilation;   // a third of the strain of the volume, as bonds tell it
  std::vector<float> kept;       // of the stress that relaxes, exp(-t / t_r), of each material

  void resize(std::size_t particles);
};

/// Stiffness of the bonds of a particle over that of their rule.
/// @param squares of their rest lengths, the sum, in spacings
float bondStiffness(float squares);

/// Measures share, secant and dilation of particles [first, last), for the rest lengths of the bonds and the
/// other numbers of the flow, of all particles.
/// @param contacts in the order of their particles
void measureFlow(const Neighbourhood& near, const Particles& particles, const Bonds& bonds,
                 const std::vector<Contact>& contacts, std::size_t first, std::size_t last, Flow& flow);

}  // namespace tactile_clay::clay
