#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "clay/contact/skin_side.h"
#include "clay/neighbourhood.h"
#include "values/skin.h"

namespace tactile_clay::clay {

/// Which samples each particle passes in a step: those that come within a radius of it at some time, if the
/// particle starts in front of them or at most this radius beneath them.
class SkinCandidates {
 public:
  /// @param radius m
  /// @param clearance m, at which contacts keep particles off the skin
  SkinCandidates(float radius, float clearance) : radius_(radius), clearance_(clearance) {}

  /// @param u m, displacements of all particles
  /// @param skin at the end of the step
  void find(const Neighbourhood& near, const VectorField& u, const Skin& skin, float dt);

  struct Range {
    const NearSample *first, *last;
  };
  /// The samples that a particle passes, in ascending order.
  Range of(std::size_t particle) const {
    return {sorted_.data() + (particle > 0 ? end_[particle - 1] : 0), sorted_.data() + end_[particle]};
  }

 private:
  struct Candidate {
    std::uint32_t particle;
    NearSample near;
  };
  void sort(std::size_t particles);

  float radius_, clearance_;                   // m
  std::vector<std::vector<Candidate>> found_;  // by chunks of the samples
  std::vector<NearSample> sorted_;             // by particle
  std::vector<std::uint32_t> end_;             // of each particle, end of its range of `sorted_`
};

}  // namespace tactile_clay::clay
