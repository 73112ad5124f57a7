#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "clay/forces/flow.h"
#include "clay/material.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"

namespace tactile_clay::clay {

/// A semi-permanent distance constraint (Eq. 5) as one of its two ends sees it.
struct Bond {
  std::uint32_t other;
  float rest_length;  // m
};

/// How two materials bond.
struct BondRule {
  float stiffness;               // N/m
  float bond_rate, unbond_rate;  // 1/s, without stiffness such that nothing holds
};

/// Which pairs hold together (paper, section III-C): bonds form where a pair's projected relative velocity is
/// low and break where it is high (hysteresis); where the stress at a particle is beyond its yield stress,
/// the rest lengths of its bonds flow (see Flow). Velocities are means of a frame, see doc/method/clay.md.
///
/// Rates are per second, |d ln l / dt|, so that they mean the same at every particle spacing. A bond is a
/// spring of stiffness k = E d (E the material's stiffness, d the spacing), which yields in shear at
/// tau_y = 2 E y (y the yield strain). Between two materials the weaker one decides. Every bond is listed at
/// both of its ends, with the same bits.
class Bonds {
 public:
  /// @param spacing m; pairs closer than 1.5 spacings can bond
  Bonds(float spacing, const std::vector<Material>& materials);

  /// (De)activates bonds, and lets rest lengths flow so that no particle is stressed beyond its yield stress.
  /// Called before a step moves anything.
  /// @param velocity m/s, means over a time that does not depend on the time step
  /// @param form whether bonds may form
  /// @param duration s, since the last update, in which stress relaxes
  /// @param contacts in the order of their particles
  void update(const Neighbourhood& near, const Particles& particles, const VectorField& velocity, bool form,
              float duration = 0.0f, const std::vector<Contact>& contacts = {});

  /// N/m, of a bond between two materials; 0: they do not bond
  float stiffness(std::uint8_t a, std::uint8_t b) const { return rules(a)[b].stiffness; }
  /// Of a material with each of all materials.
  const BondRule* rules(std::uint8_t material) const { return &rules_[material * materials_]; }

  float spacing() const { return reach_ / reach; }  // m
  std::size_t materials() const { return materials_; }
  /// J, yield stress times the volume of a particle, of each material.
  const std::vector<float>& yields() const { return yields_; }
  /// How the bonds of each particle flowed in the last update.
  const Flow& flow() const { return flow_; }

  std::size_t size() const;
  /// Bonds of particle i, in the order of its neighbours.
  const Bond* begin(std::size_t i) const { return lists_.bonds.data() + lists_.begin[i]; }
  const Bond* end(std::size_t i) const { return lists_.bonds.data() + lists_.end[i]; }
  /// Rest length of each pair of the neighbourhood of the last update, m; 0: it is not bonded. Undefined in
  /// the gaps between lists.
  const std::vector<float>& restLengths() const { return rest_lengths_; }

  /// Takes over the bonds of each particle i, from begins[i] to begins[i + 1].
  void restore(const std::vector<std::uint32_t>& begins, std::vector<Bond> all);

 private:
  struct Lists {  // with gaps, as those of the neighbours
    std::vector<std::uint32_t> begin, end;
    std::vector<Bond> bonds;
  };
  void activate(const Neighbourhood& near, const Particles& particles, const VectorField& velocity, bool form,
                std::size_t first, std::size_t last);
  void list(const Neighbourhood& near, std::size_t first, std::size_t last);

  static constexpr float reach = 1.5f;  // spacings, within which pairs can bond
  float reach_;                         // m
  std::size_t materials_;
  std::vector<BondRule> rules_;
  std::vector<float> yields_, relaxation_rates_;
  Lists lists_, before_;
  std::vector<float> rest_lengths_;
  Flow flow_;
};

}  // namespace tactile_clay::clay
