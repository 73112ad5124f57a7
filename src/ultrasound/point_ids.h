#pragma once

#include <cstdint>
#include <vector>

#include "ultrasound/focal_point.h"

namespace tactile_clay::ultrasound {

/// Gives focal points their ids, so that a point keeps its id from frame to frame.
class PointIds {
 public:
  /// Pairs points with those of the frame before, closest first (ties: lower id, then lower index). A pair
  /// that is not farther apart than `follow_distance`, m, keeps its id. The other points get the next unused
  /// ids, in their order. An id of a point that has gone is not used again. Sorts the points by id.
  void assign(std::vector<FocalPoint>& points, double follow_distance);

  /// Points of the frame before, by rising id; without intensities.
  const std::vector<FocalPoint>& before() const { return before_; }

  /// Forgets the points of the frame before; ids count on.
  void forget() { before_.clear(); }

 private:
  std::vector<FocalPoint> before_;
  std::uint32_t next_ = 0;
};

}  // namespace tactile_clay::ultrasound
