#pragma once

#include <cstdint>
#include <vector>

#include "ultrasound/focal_point.h"

namespace tactile_clay::ultrasound {

/// The blur of skin: means over the places around each, by exp(-d^2 / (2 s^2)) to 2.5 s. Rows of a sparse
/// matrix whose numbers add up to one.
class SkinBlur {
 public:
  /// @param s m; 0: what comes stays as it is
  SkinBlur(const std::vector<FocalPoint>& places, double s);
  SkinBlur() = default;

  bool none() const { return begin_.empty(); }

  /// @param values one a place
  /// @param blurred the same number; set
  void apply(const std::vector<float>& values, std::vector<float>& blurred) const;
  /// The transposed matrix, for gradients.
  void applyTransposed(const std::vector<float>& values, std::vector<float>& sums) const;

 private:
  struct Share {
    std::uint32_t place;
    float share;
  };
  std::vector<std::size_t> begin_;  // of the shares of each place, and their end
  std::vector<Share> shares_;
};

}  // namespace tactile_clay::ultrasound
