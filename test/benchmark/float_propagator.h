#pragma once

#include <algorithm>
#include <vector>

#include "lanes/wide_lanes.h"

namespace tactile_clay::ultrasound {

/// The products of FixedPropagator in floats: the baseline that it is measured against. Four rows at a time,
/// as there.
class FloatPropagator {
 public:
  static constexpr std::size_t block = 4;

  /// @param rows a multiple of `block`
  /// @param width lanes of a row
  FloatPropagator(std::size_t rows, std::size_t width)
      : rows_(rows), width_(width), g_(rows * width, ComplexLanes{}) {}

  void setRow(std::size_t m, const ComplexLanes* row) { std::copy(row, row + width_, &g_[m * width_]); }

  /// p = G q.
  void pressures(const ComplexLanes* q, float* re, float* im) const {
    for (std::size_t m = 0; m < rows_; m += block) pressures(&g_[m * width_], q, width_, re + m, im + m);
  }

  /// z = G^T u, not conjugated.
  void transposed(const float* re, const float* im, ComplexLanes* z) const {
    std::fill(z, z + width_, ComplexLanes{});
    for (std::size_t m = 0; m < rows_; m += block) addTransposed(&g_[m * width_], width_, re + m, im + m, z);
  }

 private:
  TACTILE_CLAY_MULTIVERSION static void pressures(const ComplexLanes* rows, const ComplexLanes* q,
                                                  std::size_t width, float* re, float* im) {
    Lanes sum_re[block] = {}, sum_im[block] = {};
    for (std::size_t i = 0; i < width; ++i) {
      for (std::size_t m = 0; m < block; ++m) {
        const ComplexLanes& g = rows[m * width + i];
        sum_re[m] += g.re * q[i].re - g.im * q[i].im;
        sum_im[m] += g.re * q[i].im + g.im * q[i].re;
      }
    }
    for (std::size_t m = 0; m < block; ++m) {
      re[m] = sum(sum_re[m]);
      im[m] = sum(sum_im[m]);
    }
  }

  TACTILE_CLAY_MULTIVERSION static void addTransposed(const ComplexLanes* rows, std::size_t width,
                                                      const float* re, const float* im, ComplexLanes* z) {
    for (std::size_t i = 0; i < width; ++i) {
      ComplexLanes a = z[i];
      for (std::size_t m = 0; m < block; ++m) {
        const ComplexLanes& g = rows[m * width + i];
        a.re += g.re * re[m] - g.im * im[m];
        a.im += g.re * im[m] + g.im * re[m];
      }
      z[i] = a;
    }
  }

  std::size_t rows_, width_;
  LaneArray<ComplexLanes> g_;
};

}  // namespace tactile_clay::ultrasound
