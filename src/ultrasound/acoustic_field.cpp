#include "ultrasound/acoustic_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace tactile_clay::ultrasound {
namespace {

void checkDrive(const ArrayLayout& layout, const Drive& drive) {
  if (drive.phase.size() == layout.size() && drive.amplitude.size() == layout.size()) return;
  throw std::invalid_argument("acoustic field: drive of " + std::to_string(drive.phase.size()) +
                              " phases and " + std::to_string(drive.amplitude.size()) +
                              " amplitudes, expected " + std::to_string(layout.size()) + " for layout " +
                              layout.name);
}

/// One driven transducer, prepared for single precision.
struct Source {
  float x, y, z;
  float nx, ny, nz;
  float re, im;  // P_ref a e^{i phi}
};

constexpr std::size_t block_size = 64;  // points that are summed together: fits the first-level cache

/// Points as structure of arrays, and their sums.
struct Block {
  std::array<float, block_size> x, y, z, re, im;
};

/// cos and sin of 2 pi t for t in [-1/2, 1/2], within 1e-6: Taylor series of half the angle, doubled.
inline void unitCircle(float t, float& cosine, float& sine) {
  const float a = t * 3.14159265f;
  const float b = a * a;
  const float s =
      a *
      (1.0f + b * (-1.0f / 6 + b * (1.0f / 120 + b * (-1.0f / 5040 + b * (1.0f / 362880 - b / 39916800)))));
  const float c =
      1.0f +
      b * (-1.0f / 2 +
           b * (1.0f / 24 + b * (-1.0f / 720 + b * (1.0f / 40320 + b * (-1.0f / 3628800 + b / 479001600)))));
  cosine = 1.0f - 2.0f * s * s;
  sine = 2.0f * s * c;
}

/// e^{-d}, within 1e-5 for d in [0, 8]; more counts as 8.
inline float decaying(float d) {
  const float e = -(d < 8.0f ? d : 8.0f) / 16;
  float y =
      1.0f + e * (1.0f + e * (1.0f / 2 + e * (1.0f / 6 + e * (1.0f / 24 + e * (1.0f / 120 + e / 720)))));
  y *= y;
  y *= y;
  y *= y;
  return y * y;
}

/// Adds one source to a whole block. No branch and no call, so that it is vectorised over the points.
void addSource(const Source& source, float turns_per_metre, float attenuation, float piston_squared,
               float radius, Block& block) {
  constexpr float round_off =
      12582912.0f;  // 1.5 2^23: adding and taking it away rounds to the nearest integer
  for (std::size_t i = 0; i < block_size; ++i) {
    const float dx = block.x[i] - source.x;
    const float dy = block.y[i] - source.y;
    const float dz = block.z[i] - source.z;
    const float r = std::sqrt(dx * dx + dy * dy + dz * dz);
    const float far = r > radius ? r : radius;
    const float inverse = 1.0f / far;
    const float along = dx * source.nx + dy * source.ny + dz * source.nz;
    const float cosine = along * inverse;
    const float sine_squared = 1.0f - cosine * cosine;
    const float directivity = pistonDirectivity(piston_squared * (sine_squared > 0.0f ? sine_squared : 0.0f));
    const float decay = decaying(attenuation * far);
    const float turns = r * turns_per_metre;
    float c;
    float s;
    unitCircle(turns - ((turns + round_off) - round_off), c, s);
    const float gain = along > 0.0f ? directivity * inverse * decay : 0.0f;
    block.re[i] += gain * (source.re * c - source.im * s);
    block.im[i] += gain * (source.re * s + source.im * c);
  }
}

bool reachable(const Eigen::Vector3f& point) {
  constexpr float horizon = 100.0f;  // m; nothing is heard there, and float would lose the phase
  return point.allFinite() && point.cwiseAbs().maxCoeff() < horizon;
}

}  // namespace

std::complex<double> transducerPressure(const ArrayLayout& layout, const Acoustics& acoustics, std::size_t n,
                                        const Eigen::Vector3d& point) {
  if (!point.allFinite()) return 0.0;
  const Eigen::Vector3d way = point - layout.position[n];
  const double r = way.norm();
  const double far = std::max(r, acoustics.transducer_radius);
  const double along = way.dot(layout.normal[n]);
  if (!(along > 0.0)) return 0.0;
  const double k = acoustics.wavenumber();
  const double cosine = along / far;
  const double x_squared =
      std::pow(k * acoustics.transducer_radius, 2) * std::max(1.0 - cosine * cosine, 0.0);
  return std::polar(acoustics.reference_pressure * pistonDirectivity(x_squared) / far *
                        std::exp(-acoustics.attenuation * far),
                    k * r);
}

std::complex<double> pressureAt(const ArrayLayout& layout, const Acoustics& acoustics, const Drive& drive,
                                const Eigen::Vector3d& point) {
  checkDrive(layout, drive);
  std::complex<double> sum = 0.0;
  for (std::size_t n = 0; n < layout.size(); ++n) {
    if (drive.amplitude[n] == 0.0f) continue;
    sum += std::polar<double>(drive.amplitude[n], drive.phase[n]) *
           transducerPressure(layout, acoustics, n, point);
  }
  return sum;
}

std::vector<std::complex<float>> pressuresAt(const ArrayLayout& layout, const Acoustics& acoustics,
                                             const Drive& drive, const std::vector<Eigen::Vector3f>& points) {
  checkDrive(layout, drive);
  std::vector<Source> sources;
  for (std::size_t n = 0; n < layout.size(); ++n) {
    if (drive.amplitude[n] == 0.0f) continue;
    const auto q = std::polar<double>(acoustics.reference_pressure * drive.amplitude[n], drive.phase[n]);
    const Eigen::Vector3f x = layout.position[n].cast<float>();
    const Eigen::Vector3f normal = layout.normal[n].cast<float>();
    sources.push_back({x.x(), x.y(), x.z(), normal.x(), normal.y(), normal.z(), static_cast<float>(q.real()),
                       static_cast<float>(q.imag())});
  }
  const auto turns_per_metre = static_cast<float>(1.0 / acoustics.wavelength());
  const auto attenuation = static_cast<float>(acoustics.attenuation);
  const auto radius = static_cast<float>(acoustics.transducer_radius);
  const auto piston_squared =
      static_cast<float>(std::pow(acoustics.wavenumber() * acoustics.transducer_radius, 2));

  // Each block is one task that sums its sources in order, whichever thread takes it.
  std::vector<std::complex<float>> pressures(points.size());
  const std::size_t blocks = (points.size() + block_size - 1) / block_size;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t b = range.begin(); b < range.end(); ++b) {
                        const std::size_t first = b * block_size;
                        const std::size_t count = std::min(block_size, points.size() - first);
                        Block block{};
                        for (std::size_t i = 0; i < count; ++i) {
                          if (!reachable(points[first + i])) continue;
                          block.x[i] = points[first + i].x();
                          block.y[i] = points[first + i].y();
                          block.z[i] = points[first + i].z();
                        }
                        for (const Source& source : sources) {
                          addSource(source, turns_per_metre, attenuation, piston_squared, radius, block);
                        }
                        for (std::size_t i = 0; i < count; ++i) {
                          if (reachable(points[first + i])) pressures[first + i] = {block.re[i], block.im[i]};
                        }
                      }
                    });
  return pressures;
}

double headSpl(const ArrayLayout& layout, const Acoustics& acoustics, const Drive& drive,
               const Eigen::Vector3d& head_point) {
  return soundPressureLevel(std::abs(pressureAt(layout, acoustics, drive, head_point)));
}

}  // namespace tactile_clay::ultrasound
