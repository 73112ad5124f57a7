#pragma once

#include <cmath>

#include "lanes/lanes.h"

namespace tactile_clay::clay {

/// Cubic spline kernel with compact support (Monaghan 1992, Rep. Prog. Phys. 55:543), in three dimensions.
/// Written branch-free: W(q) = sigma (2 (1 - q)+^3 - 8 (1/2 - q)+^3), q = r / h, sigma = 8 / (pi h^3).
struct Kernel {
  explicit Kernel(float support_radius)
      : h(support_radius),
        sigma(static_cast<float>(8.0 / (M_PI * std::pow(support_radius, 3.0)))),
        per_h(1.0f / h),
        steepness(sigma / h) {}

  /// W(r) in 1/m^3 for a distance r >= 0 in m. T is float or a Lane.
  template <typename T>
  TACTILE_CLAY_INLINE T value(const T& r) const {
    return 2.0f * sigma * shape(r).value;
  }

  /// dW/dr in 1/m^4, never positive.
  template <typename T>
  TACTILE_CLAY_INLINE T slope(const T& r) const {
    const T q = r * per_h;
    const T a = positive(T(1.0f - q)), b = positive(T(0.5f - q));
    return steepness * (24.0f * b * b - 6.0f * a * a);
  }

  /// W and dW/dr without their factors: W = 2 sigma value, dW/dr = steepest() slope. For loops over pairs
  /// that need both.
  template <typename T>
  struct Shape {
    T value, slope;
  };
  template <typename T>
  TACTILE_CLAY_INLINE Shape<T> shape(const T& r) const {
    const T q = r * per_h;
    const T a = positive(T(1.0f - q)), b = positive(T(0.5f - q));
    const T aa = a * a, bb = 4.0f * (b * b);
    return {aa * a - bb * b, bb - aa};
  }
  float steepest() const { return 6.0f * steepness; }  // 1/m^4

  float h;      // m, support radius
  float sigma;  // 1/m^3, W(0)

 private:
  float per_h, steepness;  // stored, since the compiler may not move their divisions out of a loop
  static TACTILE_CLAY_INLINE float positive(float x) { return x > 0.0f ? x : 0.0f; }
  static TACTILE_CLAY_INLINE Lane positive(const Lane& x) { return tactile_clay::positive(x); }
};

}  // namespace tactile_clay::clay
