#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "clay/contact/skin_side.h"
#include "clay/ghosts.h"
#include "clay/neighbourhood.h"

namespace tactile_clay::clay {

/// Which ghosts each particle passes in a step: those that come within a radius of it at some time, and that
/// it started in front of, or not deeper beneath than that.
class SkinCandidates {
 public:
  /// \param radius m
  explicit SkinCandidates(float radius) : radius_(radius) {}

  /// \param u m, displacements of all particles \param ghosts at the end of the step
  void find(const Neighbourhood& near, const VectorField& u, const Ghosts& ghosts, float dt);

  struct Range {
    const NearGhost *first, *last;
  };
  /// Those of a particle, in ascending order.
  Range of(std::size_t particle) const {
    return {sorted_.data() + (particle > 0 ? end_[particle - 1] : 0), sorted_.data() + end_[particle]};
  }

 private:
  struct Candidate {
    std::uint32_t particle;
    NearGhost near;
  };
  void sort(std::size_t particles);

  float radius_;
  std::vector<std::vector<Candidate>> found_;  // by chunks of the ghosts
  std::vector<NearGhost> sorted_;              // by particle
  std::vector<std::uint32_t> end_;             // of each particle, where the next one's begin
};

}  // namespace tactile_clay::clay
