#pragma once

#include <cstddef>
#include <vector>

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
/// by exp(-t / t_r) in a time t. Worked clay has more bonds than the initial lattice, up to 2.6 times as
/// stiff, and relaxes as much faster, so that its viscosity E t_r stays.
struct Flow {
  std::vector<float> share;     // of the elongations; 1: does not flow
  std::vector<float> dilation;  // a third of the strain of the volume, as bonds tell it
  std::vector<float> fading;    // time of the last step over the relaxation time, of each material

  void resize(std::size_t particles);
};

/// Measures it of particles [first, last), for the rest lengths that the bonds have and the `fading` of the
/// flow.
void measureFlow(const Neighbourhood& near, const Particles& particles, const Bonds& bonds, std::size_t first,
                 std::size_t last, Flow& flow);

}  // namespace tactile_clay::clay
