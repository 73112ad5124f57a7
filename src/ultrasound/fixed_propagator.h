#pragma once

#include <cstdint>
#include <vector>

#include "lanes/wide_lanes.h"

namespace tactile_clay::ultrasound {

/// The matrix G of p = G q in whole numbers of sixteen bits. They need half of the memory of floats, and
/// processors have an instruction for two products and their sum. Sums of whole numbers are exact, so all
/// processors give the same bits. If the amplitudes of a row add up to r, its pressure is off by some 1e-5 r
/// (root mean square, 256 transducers).
class FixedPropagator {
 public:
  /// @param rows a multiple of `block`; all zero at first
  /// @param width lanes of a row
  FixedPropagator(std::size_t rows, std::size_t width);

  /// Rows or lanes that are processed together: their sums fit into the registers.
  static constexpr std::size_t block = 4;

  /// @param row of `width` lanes
  /// @param reach sum of the amplitudes in it, above 0
  void setRow(std::size_t m, const ComplexLanes* row, float reach);

  /// Multiplies all rows.
  void scale(float factor);

  /// p = G q.
  /// @param q of amplitude 1 at most, `width` lanes
  /// @param re, im receive one value per row
  void pressures(const ComplexLanes* q, float* re, float* im);

  /// z = G^T u, not conjugated.
  /// @param re, im of u, one value per row
  /// @param z receives `width` lanes
  void transposed(const float* re, const float* im, ComplexLanes* z);

 private:
  std::size_t rows_, width_, padded_;       // padded: width up to whole blocks of lanes
  LaneArray<LaneBits> g_;                   // real and imaginary part of a transducer in a lane
  std::vector<float> unit_;                 // value of a 1 in each row
  LaneArray<LaneBits> straight_, crossed_;  // of q: (re, -im) and (im, re)
  std::vector<std::int32_t> whole_;         // pressures, then u: two numbers per row
  LaneArray<LaneBits> sum_re_, sum_im_;     // parts of z
};

}  // namespace tactile_clay::ultrasound
