#include "ultrasound/fixed_propagator.h"

#include <algorithm>
#include <cmath>

#if TACTILE_CLAY_TARGETS
#include <immintrin.h>
#endif

namespace tactile_clay::ultrasound {
namespace {

// Sums stay below 2^31. A row: 2^19 (sum of |g|) times 2^11 (|q|). A column: 64 rows of 2^14 times sqrt 2
// times 2^10 (|u|).
constexpr float row_sum = 524288.0f, max_in_row = 16384.0f, one = 2048.0f, max_of_u = 1024.0f;
constexpr std::size_t rows_a_sum = 64;

TACTILE_CLAY_MULTIVERSION float largest(const ComplexLanes* row, std::size_t width) {
  Lanes maximum{};
  for (std::size_t i = 0; i < width; ++i)
    maximum = max(maximum, row[i].re * row[i].re + row[i].im * row[i].im);
  float largest = 0.0f;
  for (std::size_t lane = 0; lane < wide_lane_count; ++lane) largest = std::max(largest, maximum[lane]);
  return std::sqrt(largest);
}

TACTILE_CLAY_INLINE LaneBits whole(Lanes a) {
  return __builtin_convertvector(nearest(a), LaneBits);
}

/// A lane from its low and its high half.
TACTILE_CLAY_INLINE LaneBits pair(LaneBits low, LaneBits high) {
  return (high << 16) | (low & 0xffff);
}

TACTILE_CLAY_MULTIVERSION void roundRow(const ComplexLanes* row, std::size_t width, float scale,
                                        LaneBits* out) {
  for (std::size_t i = 0; i < width; ++i) out[i] = pair(whole(row[i].re * scale), whole(row[i].im * scale));
}

TACTILE_CLAY_MULTIVERSION void roundDrive(const ComplexLanes* q, std::size_t width, LaneBits* straight,
                                          LaneBits* crossed) {
  for (std::size_t i = 0; i < width; ++i) {
    const LaneBits re = whole(q[i].re * one), im = whole(q[i].im * one);
    straight[i] = pair(re, -im);
    crossed[i] = pair(im, re);
  }
}

TACTILE_CLAY_MULTIVERSION void addScaledRow(const LaneBits* re, const LaneBits* im, std::size_t width,
                                            float unit, ComplexLanes* z) {
  for (std::size_t i = 0; i < width; ++i) {
    z[i].re += unit * __builtin_convertvector(re[i], Lanes);
    z[i].im += unit * __builtin_convertvector(im[i], Lanes);
  }
}

/// Pairs (re, -im) and (im, re) of each u, in whole numbers.
/// @param unit, scale each u is multiplied by its unit and by `scale`
TACTILE_CLAY_MULTIVERSION void roundPairs(const float* re, const float* im, const float* unit, float scale,
                                          std::size_t count, std::int32_t* pairs) {
  for (std::size_t m = 0; m < count; ++m) {
    const float here = scale * unit[m];
    const auto a = static_cast<std::int32_t>(nearest(here * re[m]));
    const auto b = static_cast<std::int32_t>(nearest(here * im[m]));
    pairs[2 * m] = (a & 0xffff) - b * 65536;
    pairs[2 * m + 1] = (b & 0xffff) + a * 65536;
  }
}

TACTILE_CLAY_MULTIVERSION float largestPart(const float* re, const float* im, const float* unit,
                                            std::size_t count) {
  float maximum = 0.0f;
  for (std::size_t m = 0; m < count; ++m) {
    const float here = unit[m] * std::max(std::abs(re[m]), std::abs(im[m]));
    maximum = maximum < here ? here : maximum;
  }
  return maximum;
}

/// Sum of the numbers of a.
template <typename Whole>
TACTILE_CLAY_INLINE std::int32_t total(const Whole& a) {
  using Four = std::int32_t __attribute__((vector_size(16)));
  Four part[sizeof(Whole) / sizeof(Four)];
  std::memcpy(part, &a, sizeof a);
  for (std::size_t n = 1; n < sizeof(Whole) / sizeof(Four); ++n) part[0] += part[n];
  return (part[0][0] + part[0][1]) + (part[0][2] + part[0][3]);
}

namespace plain {
using Whole = LaneBits;
inline Whole multiplyAdd(const Whole& sum, const Whole& a, const Whole& b) {
  return sum + ((a << 16) >> 16) * ((b << 16) >> 16) + (a >> 16) * (b >> 16);
}
#include "ultrasound/fixed_kernels.inc"
}  // namespace plain

#if TACTILE_CLAY_TARGETS
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
using Whole = std::int32_t __attribute__((vector_size(32)));
TACTILE_CLAY_INLINE Whole multiplyAdd(Whole sum, Whole a, Whole b) {
  return sum + reinterpret_cast<Whole>(
                   _mm256_madd_epi16(reinterpret_cast<__m256i>(a), reinterpret_cast<__m256i>(b)));
}
#include "ultrasound/fixed_kernels.inc"
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw,avx512vnni")
namespace vnni {
using Whole = LaneBits;
TACTILE_CLAY_INLINE Whole multiplyAdd(Whole sum, Whole a, Whole b) {
  return reinterpret_cast<Whole>(_mm512_dpwssd_epi32(
      reinterpret_cast<__m512i>(sum), reinterpret_cast<__m512i>(a), reinterpret_cast<__m512i>(b)));
}
#include "ultrasound/fixed_kernels.inc"
}  // namespace vnni
#pragma GCC pop_options
#endif

struct Kernels {
  decltype(&plain::pressures) pressures;
  decltype(&plain::transposed) transposed;
};

/// The fastest kernels that this processor can run.
const Kernels& kernels() {
  static const Kernels best = [] {
#if TACTILE_CLAY_TARGETS
    if (__builtin_cpu_supports("avx512vnni") && __builtin_cpu_supports("avx512bw"))
      return Kernels{vnni::pressures, vnni::transposed};
    if (__builtin_cpu_supports("avx2")) return Kernels{avx2::pressures, avx2::transposed};
#endif
    return Kernels{plain::pressures, plain::transposed};
  }();
  return best;
}

}  // namespace

FixedPropagator::FixedPropagator(std::size_t rows, std::size_t width)
    : rows_(rows),
      width_(width),
      padded_((width + block - 1) / block * block),
      g_(rows * padded_, LaneBits{}),
      unit_(rows, 0.0f),
      straight_(padded_, LaneBits{}),
      crossed_(padded_, LaneBits{}),
      whole_(2 * rows),
      sum_re_(padded_),
      sum_im_(padded_) {}

void FixedPropagator::setRow(std::size_t m, const ComplexLanes* row, float reach) {
  const float scale = std::min(row_sum / reach, max_in_row / std::max(largest(row, width_), 1e-30f));
  roundRow(row, width_, scale, &g_[m * padded_]);
  unit_[m] = 1.0f / scale;
}

void FixedPropagator::scale(float factor) {
  for (float& unit : unit_) unit *= factor;
}

void FixedPropagator::pressures(const ComplexLanes* q, float* re, float* im) {
  roundDrive(q, width_, straight_.data(), crossed_.data());
  std::int32_t *whole_re = whole_.data(), *whole_im = whole_re + rows_;
  kernels().pressures(g_.data(), straight_.data(), crossed_.data(), rows_, padded_, whole_re, whole_im);
  for (std::size_t m = 0; m < rows_; ++m) {
    const float unit = unit_[m] / one;
    re[m] = unit * static_cast<float>(whole_re[m]);
    im[m] = unit * static_cast<float>(whole_im[m]);
  }
}

void FixedPropagator::transposed(const float* re, const float* im, ComplexLanes* z) {
  std::fill(z, z + width_, ComplexLanes{});
  for (std::size_t first = 0; first < rows_; first += rows_a_sum) {
    const std::size_t count = std::min(rows_a_sum, rows_ - first);
    const float maximum = largestPart(re + first, im + first, &unit_[first], count);
    if (!(maximum > 0.0f)) continue;
    const float scale = max_of_u / maximum;
    roundPairs(re + first, im + first, &unit_[first], scale, count, whole_.data());
    kernels().transposed(&g_[first * padded_], whole_.data(), count, padded_, sum_re_.data(), sum_im_.data());
    addScaledRow(sum_re_.data(), sum_im_.data(), width_, 1.0f / scale, z);
  }
}

}  // namespace tactile_clay::ultrasound
