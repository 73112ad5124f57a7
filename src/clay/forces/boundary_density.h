#pragma once

#include <cstdint>
#include <vector>

#include "clay/contact/contact.h"
#include "clay/kernel.h"
#include "clay/material.h"
#include "clay/particles.h"

namespace tactile_clay::clay {

/// What solids add to the density of the particles on them, so that what has no bonds does not pack against
/// them. Bonds keep clay from packing, and so clay does without.
///
/// A solid counts as clay that ends half a spacing before the particle: the particle has the share w_0 of the
/// lattice's kernel sum from it. Several solids leave 1 - (1 - w_0)(1 - w_0)..., which at an edge and in a
/// corner is what the lattice lacks there, within 0.01. Of two on the same side (boxes that make up a table)
/// one counts.
///
/// A contact takes its share as far as the particle lacks density, and keeps it until it opens. So no
/// particle is compressed by touching a solid: a share neither does work nor needs a force, and a lump that
/// is already packed, or was started inside a table, is not lifted off.
class BoundaryDensity {
 public:
  BoundaryDensity(const Kernel& kernel, float spacing, const std::vector<Material>& materials);

  struct Share {
    std::uint32_t particle;
    float ratio;  // of rho_0
  };
  /// Finds the shares of a step; contacts must remember them.
  /// @param ratio rho / rho_0 of the particles at the start of the step
  /// @param contacts in the order of their particles
  const std::vector<Share>& update(const Particles& particles, const std::vector<float>& ratio,
                                   const std::vector<Contact>& contacts);
  const std::vector<Share>& shares() const { return shares_; }

 private:
  float wall_share_;         // w_0
  std::vector<bool> packs_;  // which materials have density and no bonds
  std::vector<Share> shares_;
};

}  // namespace tactile_clay::clay
