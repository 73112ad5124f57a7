#include "ultrasound/skin_samples.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>

namespace tactile_clay::ultrasound {
namespace {

using contact::PressureSample;

constexpr double cell = 0.004;                 // m, cells of the curve; smaller than the distance of samples
constexpr std::int64_t middle_cell = 1 << 20;  // of the 21 bits per coordinate: 4 km to either side

/// Index of a cell on the curve: the bits of its coordinates, interleaved.
std::uint64_t placeOnCurve(const Eigen::Vector3f& position) {
  std::uint64_t place = 0;
  std::uint64_t coordinate[3];
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::int64_t>(std::floor(static_cast<double>(position[axis]) / cell));
    coordinate[axis] =
        static_cast<std::uint64_t>(std::clamp<std::int64_t>(at + middle_cell, 0, 2 * middle_cell - 1));
  }
  for (int bit = 20; bit >= 0; --bit)
    for (const std::uint64_t x : coordinate) place = place << 1 | (x >> bit & 1);
  return place;
}

/// Cuts a part of the skin, sorted along the curve, into pieces of about this area.
void cutPieces(std::vector<PressureSample>::const_iterator begin,
               std::vector<PressureSample>::const_iterator end, double area,
               std::vector<SkinSample>& pieces) {
  double total = 0.0;
  for (auto sample = begin; sample != end; ++sample) total += sample->area;
  if (!(total > 0.0)) return;
  const auto count = static_cast<std::size_t>(std::max(1.0, std::floor(total / area * (1.0 + 1e-9))));
  double passed = 0.0;  // area before the sample
  auto sample = begin;
  for (std::size_t k = 0; k < count && sample != end; ++k) {
    const double last = total * static_cast<double>(k + 1) / static_cast<double>(count);
    const double centre = 0.5 * (passed + last);
    SkinSample piece{sample->position.cast<double>(), 0.0, 0.0, 0.0, sample->normal.cast<double>()};
    double felt = 0.0, weight = 0.0, taken = 0.0;
    // A sample belongs to the piece in which its middle lies.
    for (; sample != end && (passed + 0.5 * sample->area <= last || k + 1 == count); ++sample) {
      const double here = sample->area;
      if (passed <= centre) {
        piece.position = sample->position.cast<double>();
        piece.normal = sample->normal.cast<double>();
      }
      felt += here * sample->pressure;
      weight += here * sample->weight;
      taken += here;
      passed += here;
    }
    if (!(taken > 0.0)) continue;
    piece.pressure = felt / taken;
    piece.area = taken;
    piece.weight = weight / taken;
    pieces.push_back(piece);
  }
}

}  // namespace

std::vector<SkinSample> skinSamples(const std::vector<PressureSample>& skin, std::size_t maximum) {
  std::vector<std::pair<std::uint64_t, PressureSample>> sorted;
  double total = 0.0;
  for (const PressureSample& sample : skin) {
    sorted.emplace_back(placeOnCurve(sample.position), sample);
    total += sample.area;
  }
  const auto key = [](const auto& entry) {
    const PressureSample& s = entry.second;
    const auto position = std::make_tuple(s.position.x(), s.position.y(), s.position.z());
    const auto normal = std::make_tuple(s.normal.x(), s.normal.y(), s.normal.z());
    return std::make_tuple(!(s.pressure > 0.0f), entry.first, position, s.pressure, s.area, s.weight, normal);
  };
  std::sort(sorted.begin(), sorted.end(), [&key](const auto& a, const auto& b) { return key(a) < key(b); });
  std::vector<PressureSample> ordered;
  for (const auto& entry : sorted) ordered.push_back(entry.second);
  std::vector<SkinSample> pieces;
  if (ordered.size() <= maximum) {
    for (const PressureSample& sample : ordered)
      pieces.push_back({sample.position.cast<double>(), sample.pressure, sample.area, sample.weight,
                        sample.normal.cast<double>()});
    return pieces;
  }
  const auto bare = std::find_if(ordered.cbegin(), ordered.cend(),
                                 [](const PressureSample& sample) { return !(sample.pressure > 0.0f); });
  const double area = total / static_cast<double>(maximum);
  cutPieces(ordered.cbegin(), bare, area, pieces);
  cutPieces(bare, ordered.cend(), area, pieces);
  return pieces;
}

}  // namespace tactile_clay::ultrasound
