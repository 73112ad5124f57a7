#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "clay/material.h"
#include "clay/neighbourhood.h"
#include "clay/particles.h"

namespace tactile_clay::clay {

/// A semi-permanent distance constraint (Eq. 5) as one of its two ends sees it.
struct Bond {
  std::uint32_t other;
  float rest_length;  // m
};

/// Which pairs hold together (paper, section III-C): bonds form where a pair's projected relative velocity is
/// low and break where it is high (hysteresis); the rest length of an overstretched bond flows.
///
/// Rates are per second, |d ln l / dt|, so that they mean the same at every particle spacing. A bond is a
/// spring of stiffness k = E d (E the material's stiffness, d the spacing). Between two materials the weaker
/// one decides. Every bond is listed at both of its ends, with the same bits.
class Bonds {
 public:
  /// \param spacing m; pairs closer than 1.5 spacings can bond
  Bonds(float spacing, const std::vector<Material>& materials);

  /// Lets rest lengths follow so that no bond is strained beyond its yield strain, and (de)activates bonds by
  /// the velocities of the last step. Called before the step moves anything.
  void update(const Neighbourhood& near, const Particles& particles);

  /// N/m, of a bond between two materials; 0: they do not bond
  float stiffness(std::uint8_t a, std::uint8_t b) const { return rule(a, b).stiffness; }

  std::size_t size() const { return bonds_.size() / 2; }
  /// All lists, one after the other, and where each begins; none before the first update.
  const std::vector<std::uint32_t>& begins() const { return begin_; }
  const std::vector<Bond>& all() const { return bonds_; }
  void restore(std::vector<std::uint32_t> begins, std::vector<Bond> all) {
    begin_ = std::move(begins), bonds_ = std::move(all);
  }
  /// Bonds of particle i, in the order of its neighbours.
  const Bond* begin(std::size_t i) const { return bonds_.data() + begin_[i]; }
  const Bond* end(std::size_t i) const { return bonds_.data() + begin_[i + 1]; }

 private:
  struct PairRule {
    float stiffness;  // N/m
    float bond_rate, unbond_rate;
    float shortest, longest;  // rest lengths of a bond at its yield, over its length
  };
  const PairRule& rule(std::uint8_t a, std::uint8_t b) const { return rules_[a * materials_ + b]; }

  static constexpr std::size_t chunk_size = 256;
  struct Chunk {
    std::vector<Bond> bonds;  // of a run of particles, one particle after the other; `size` in all
    std::size_t size;
    std::array<std::uint32_t, chunk_size> count;
  };
  void updateIn(Chunk& chunk, const Neighbourhood& near, const Particles& particles, std::size_t first,
                std::size_t last);

  float reach_;  // m
  std::size_t materials_;
  std::vector<PairRule> rules_;
  std::vector<std::uint32_t> begin_;
  std::vector<Bond> bonds_;
  std::vector<Chunk> chunks_;
};

}  // namespace tactile_clay::clay
