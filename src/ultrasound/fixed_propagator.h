#pragma once

#include <cstdint>
#include <vector>

#include "lanes/wide_lanes.h"

namespace tactile_clay::ultrasound {

/// G of p = G q in whole numbers of sixteen bits: half of the memory of floats, and processors have an
/// instruction for two products and their sum. Sums of whole numbers are exact, so that all processors have
/// the same bits. Where the array gives r at most in a row, the pressure there is off by some 1e-5 r (root
/// mean square, 256 transducers).
class FixedPropagator {
 public:
  /// @param rows a multiple of `block`; all zero at first
  /// @param width lanes of a row
  FixedPropagator(std::size_t rows, std::size_t width);

  static constexpr std::size_t block =
      4;  // rows or lanes that are worked on together: their sums fit the registers

  /// @param row of `width` lanes
  /// @param reach sum of the amplitudes in it, above 0
  void setRow(std::size_t m, const ComplexLanes* row, float reach);

  /// Multiplies all rows.
  void scale(float factor);

  /// p = G q.
  /// @param q of amplitude 1 at most, `width` lanes
  /// @param re, im set, one a row
  void pressures(const ComplexLanes* q, float* re, float* im);

  /// z = G^T u, not conjugated.
  /// @param re, im of u, one a row
  /// @param z set, `width` lanes
  void transposed(const float* re, const float* im, ComplexLanes* z);

 private:
  std::size_t rows_, width_, padded_;       // padded: to whole blocks of lanes
  LaneArray<LaneBits> g_;                   // real and imaginary part of a transducer in a lane
  std::vector<float> unit_;                 // of the numbers of each row
  LaneArray<LaneBits> straight_, crossed_;  // of q: (re, -im) and (im, re)
  std::vector<std::int32_t> whole_;         // pressures, then u: as many numbers as two a row
  LaneArray<LaneBits> sum_re_, sum_im_;     // of z
};

}  // namespace tactile_clay::ultrasound
