#pragma once

#include <cstdint>
#include <vector>

#include "ultrasound/focal_point.h"

namespace tactile_clay::ultrasound {

/// The blur of pressure by skin: for each place the mean over the places within 2.5 s, weighted by exp(-d^2 /
/// (2 s^2)). It is a sparse matrix whose rows add up to one.
class SkinBlur {
 public:
  /// @param s m; 0: no blur
  SkinBlur(const std::vector<FocalPoint>& places, double s);
  SkinBlur() = default;

  bool none() const { return begin_.empty(); }

  /// @param values one per place
  /// @param blurred receives one per place
  void apply(const std::vector<float>& values, std::vector<float>& blurred) const;
  /// The transposed matrix, for gradients.
  void applyTransposed(const std::vector<float>& values, std::vector<float>& sums) const;

 private:
  struct Share {
    std::uint32_t place;
    float share;
  };
  std::vector<std::size_t> begin_;  // index of the first share of each place, and the end of all shares
  std::vector<Share> shares_;
};

}  // namespace tactile_clay::ultrasound
