#include "ultrasound/acoustic_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

#include "ultrasound/piston_source.h"

namespace tactile_clay::ultrasound {
namespace {

void checkDrive(const ArrayLayout& layout, const Drive& drive) {
  if (drive.phase.size() == layout.size() && drive.amplitude.size() == layout.size()) return;
  throw std::invalid_argument("acoustic field: drive of " + std::to_string(drive.phase.size()) +
                              " phases and " + std::to_string(drive.amplitude.size()) +
                              " amplitudes, expected " + std::to_string(layout.size()) + " for layout " +
                              layout.name);
}

void checkNormals(std::size_t points, std::size_t normals) {
  if (normals == 0 || normals == points) return;
  throw std::invalid_argument("acoustic field: " + std::to_string(normals) + " normals, expected " +
                              std::to_string(points) + ", one for each point, or none");
}

constexpr std::size_t block_size = 4 * wide_lane_count;  // points that are processed together

/// Points as structure of arrays, normals of the skin there, and the pressures summed at them.
struct Block {
  std::array<float, block_size> x, y, z, nx, ny, nz, re, im;

  void setPoint(std::size_t i, const Eigen::Vector3f& at) {
    x[i] = at.x();
    y[i] = at.y();
    z[i] = at.z();
  }
  void setNormal(std::size_t i, const Eigen::Vector3f& normal) {
    nx[i] = normal.x();
    ny[i] = normal.y();
    nz[i] = normal.z();
  }
};

Lanes load(const float* from) {
  Lanes a;
  std::memcpy(&a, from, sizeof a);
  return a;
}

void store(const Lanes& a, float* to) {
  std::memcpy(to, &a, sizeof a);
}

/// Sums all sources, in their order, at each point of a block.
/// @tparam simple the sources lie in one plane of equal z and look along z, and the air attenuates little
template <bool simple>
TACTILE_CLAY_INLINE void sumBlock(const std::vector<PistonSource>& sources, const PistonConstants& air,
                                  Block& block) {
  for (std::size_t i = 0; i < block_size; i += wide_lane_count) {
    const LanePoints at{load(&block.x[i]), load(&block.y[i]), load(&block.z[i])};
    const Lanes height = at.z - sources.front().z;
    const Lanes height_squared = height * height;
    Lanes re{};
    Lanes im{};
    for (const PistonSource& source : sources)
      addWave<simple>(source, air, at, height, height_squared, re, im);
    store(re, &block.re[i]);
    store(im, &block.im[i]);
  }
}

TACTILE_CLAY_MULTIVERSION void sumSimple(const std::vector<PistonSource>& sources, const PistonConstants& air,
                                         Block& block) {
  sumBlock<true>(sources, air, block);
}

TACTILE_CLAY_MULTIVERSION void sumSources(const std::vector<PistonSource>& sources,
                                          const PistonConstants& air, Block& block) {
  sumBlock<false>(sources, air, block);
}

TACTILE_CLAY_MULTIVERSION void sumOnSkin(const std::vector<PistonSource>& sources, const PistonConstants& air,
                                         Block& block) {
  for (std::size_t i = 0; i < block_size; i += wide_lane_count) {
    const LanePoints at{load(&block.x[i]), load(&block.y[i]), load(&block.z[i])};
    const LanePoints normal{load(&block.nx[i]), load(&block.ny[i]), load(&block.nz[i])};
    Lanes re{};
    Lanes im{};
    for (const PistonSource& source : sources) addWaveOnSkin(source, air, at, normal, re, im);
    store(re, &block.re[i]);
    store(im, &block.im[i]);
  }
}

bool inOnePlane(const std::vector<PistonSource>& sources) {
  return std::all_of(sources.begin(), sources.end(), [&](const PistonSource& source) {
    return source.nx == 0.0f && source.ny == 0.0f && source.nz == 1.0f && source.z == sources.front().z;
  });
}

bool reachable(const Eigen::Vector3f& point) {
  constexpr float horizon = 100.0f;  // m; the pressure there is negligible, and float would lose the phase
  return point.allFinite() && point.cwiseAbs().maxCoeff() < horizon;
}

/// Whether the air lowers the amplitude by the factor e^{-1/2} at most, on every way from a source to a point
/// in reach.
bool airTakesLittle(const std::vector<PistonSource>& sources, const std::vector<Eigen::Vector3f>& points,
                    float attenuation) {
  float reach = 0.0f;  // m, in each coordinate
  for (const PistonSource& source : sources)
    reach = std::max({reach, std::abs(source.x), std::abs(source.y), std::abs(source.z)});
  float far = 0.0f;
  for (const Eigen::Vector3f& point : points)
    if (reachable(point)) far = std::max(far, point.cwiseAbs().maxCoeff());
  return attenuation * std::sqrt(3.0f) * (reach + far) <= 0.5f;
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
                                             const Drive& drive, const std::vector<Eigen::Vector3f>& points,
                                             const std::vector<Eigen::Vector3f>& normals) {
  checkDrive(layout, drive);
  checkNormals(points.size(), normals.size());
  std::vector<PistonSource> sources;
  for (std::size_t n = 0; n < layout.size(); ++n) {
    if (drive.amplitude[n] == 0.0f) continue;
    sources.push_back(pistonSource(layout, acoustics, drive, n));
  }
  std::vector<std::complex<float>> pressures(points.size());
  if (sources.empty()) return pressures;
  const PistonConstants air(acoustics);
  const bool simple = inOnePlane(sources) && airTakesLittle(sources, points, air.attenuation);
  const auto sum = !normals.empty() ? sumOnSkin : simple ? sumSimple : sumSources;

  // Each block is one task that sums its sources in order, whichever thread takes it.
  const std::size_t blocks = (points.size() + block_size - 1) / block_size;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t b = range.begin(); b < range.end(); ++b) {
                        const std::size_t first = b * block_size;
                        const std::size_t count = std::min(block_size, points.size() - first);
                        Block block{};
                        for (std::size_t i = 0; i < count; ++i) {
                          if (!reachable(points[first + i])) continue;
                          block.setPoint(i, points[first + i]);
                          if (!normals.empty()) block.setNormal(i, normals[first + i]);
                        }
                        sum(sources, air, block);
                        for (std::size_t i = 0; i < count; ++i) {
                          if (reachable(points[first + i])) pressures[first + i] = {block.re[i], block.im[i]};
                        }
                      }
                    });
  return pressures;
}

std::vector<float> meanAmplitudesAt(const ArrayLayout& layout, const Acoustics& acoustics,
                                    const std::vector<Drive>& drives,
                                    const std::vector<Eigen::Vector3f>& points,
                                    const std::vector<Eigen::Vector3f>& normals) {
  checkNormals(points.size(), normals.size());
  std::vector<float> amplitudes(points.size(), 0.0f);
  if (drives.empty()) return amplitudes;
  for (const Drive& drive : drives) {
    const auto pressures = pressuresAt(layout, acoustics, drive, points, normals);
    for (std::size_t i = 0; i < points.size(); ++i) amplitudes[i] += std::norm(pressures[i]);
  }
  for (float& amplitude : amplitudes) amplitude = std::sqrt(amplitude / static_cast<float>(drives.size()));
  return amplitudes;
}

double headSpl(const ArrayLayout& layout, const Acoustics& acoustics, const Drive& drive,
               const Eigen::Vector3d& head_point) {
  return soundPressureLevel(std::abs(pressureAt(layout, acoustics, drive, head_point)));
}

}  // namespace tactile_clay::ultrasound
