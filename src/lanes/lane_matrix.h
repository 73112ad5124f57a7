#pragma once

#include <cstddef>
#include <cstring>

#include "lanes/lanes.h"

namespace tactile_clay {

/// Eight symmetric 3 x 3 matrices.
struct Symmetric {
  Lane xx, yy, zz, yz, zx, xy;
};

/// Eight 3 x 3 matrices.
struct Columns {
  LaneVector x, y, z;
};
TACTILE_CLAY_INLINE Columns columnsOf(const Symmetric& s) {
  return {{s.xx, s.xy, s.zx}, {s.xy, s.yy, s.yz}, {s.zx, s.yz, s.zz}};
}
TACTILE_CLAY_INLINE LaneVector times(const Columns& a, const LaneVector& v) {
  return {a.x.x * v.x + a.y.x * v.y + a.z.x * v.z, a.x.y * v.x + a.y.y * v.y + a.z.y * v.z,
          a.x.z * v.x + a.y.z * v.y + a.z.z * v.z};
}
TACTILE_CLAY_INLINE Columns times(const Columns& a, const Columns& b) {
  return {times(a, b.x), times(a, b.y), times(a, b.z)};
}
TACTILE_CLAY_INLINE Lane dot(const Columns& a, const Columns& b) {
  return dot(a.x, b.x) + dot(a.y, b.y) + dot(a.z, b.z);
}
TACTILE_CLAY_INLINE Symmetric upperOf(const Columns& a) {
  return {a.x.x, a.y.y, a.z.z, a.z.y, a.z.x, a.y.x};
}
/// The lanes of a for which `holds` is true, else zero.
TACTILE_CLAY_INLINE Symmetric where(const LaneOrder& holds, const Symmetric& a) {
  return {holds ? a.xx : Lane{}, holds ? a.yy : Lane{}, holds ? a.zz : Lane{},
          holds ? a.yz : Lane{}, holds ? a.zx : Lane{}, holds ? a.xy : Lane{}};
}
TACTILE_CLAY_INLINE Symmetric times(const Lane& a, const Symmetric& s) {
  return {a * s.xx, a * s.yy, a * s.zz, a * s.yz, a * s.zx, a * s.xy};
}
TACTILE_CLAY_INLINE Symmetric sum(const Symmetric& a, const Symmetric& b) {
  return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.yz + b.yz, a.zx + b.zx, a.xy + b.xy};
}
TACTILE_CLAY_INLINE Lane trace(const Symmetric& a) {
  return a.xx + a.yy + a.zz;
}
TACTILE_CLAY_INLINE Symmetric deviator(const Symmetric& a) {
  const Lane mean = trace(a) / 3.0f;
  return {a.xx - mean, a.yy - mean, a.zz - mean, a.yz, a.zx, a.xy};
}
/// The sum of the products of all nine components.
TACTILE_CLAY_INLINE Lane product(const Symmetric& a, const Symmetric& b) {
  return a.xx * b.xx + a.yy * b.yy + a.zz * b.zz + 2.0f * (a.yz * b.yz + a.zx * b.zx + a.xy * b.xy);
}
TACTILE_CLAY_INLINE void addOuter(Symmetric& to, const LaneVector& a, const LaneVector& b) {
  to.xx += a.x * b.x;
  to.yy += a.y * b.y;
  to.zz += a.z * b.z;
  to.yz += a.y * b.z;
  to.zx += a.z * b.x;
  to.xy += a.x * b.y;
}

/// Solves a x = b for a symmetric positive definite matrix (L D L^T).
/// @param a its lower triangle; gets L below the diagonal, and 1 / D on it; 1 / D is zero if D is not above
/// zero
template <int n>
TACTILE_CLAY_INLINE void solveSymmetric(Lane (&a)[n][n], const Lane (&b)[n], Lane (&x)[n]) {
  for (int i = 0; i < n; ++i) {
    Lane pivot = a[i][i];
    x[i] = b[i];
    for (int j = 0; j < i; ++j) {
      Lane scaled = a[i][j];  // L D
      for (int k = 0; k < j; ++k) scaled -= a[i][k] * a[j][k];
      a[i][j] = scaled;
    }
    for (int j = 0; j < i; ++j) {
      const Lane scaled = a[i][j];
      a[i][j] = scaled * a[j][j];
      pivot -= scaled * a[i][j];
      x[i] -= a[i][j] * x[j];
    }
    a[i][i] = pivot > 0.0f ? 1.0f / pivot : Lane{};
  }
  for (int i = n - 1; i >= 0; --i) {
    x[i] *= a[i][i];
    for (int k = i + 1; k < n; ++k) x[i] -= a[k][i] * x[k];
  }
}

/// Sums over the pairs of each of eight particles: the input is lanes of pairs, the output is lanes of
/// particles. T consists of lanes only.
template <typename T>
struct Totals {
  static constexpr int size = sizeof(T) / sizeof(Lane);
  Lane of[size][lane_width];

  explicit TACTILE_CLAY_INLINE Totals(std::size_t particles) {
    if (particles < lane_width) std::memset(of, 0, sizeof of);
  }

  TACTILE_CLAY_INLINE void set(int k, const T& total) {
    Lane lanes[size];
    std::memcpy(lanes, &total, sizeof total);
    for (int c = 0; c < size; ++c) of[c][k] = lanes[c];
  }
  TACTILE_CLAY_INLINE T get() const {
    Lane lanes[size];
    for (int c = 0; c < size; ++c) lanes[c] = sums(of[c]);
    T result;
    std::memcpy(&result, lanes, sizeof result);
    return result;
  }
};

}  // namespace tactile_clay
