#include "ultrasound/field_maximum.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>
#include <string>

#include "ultrasound/driven_groups.h"

namespace tactile_clay::ultrasound {
namespace {

constexpr std::size_t max_parts = 4096;  // parts of cells that are followed at one depth
constexpr std::size_t max_climbs = 12;
constexpr int climb_steps = 24, climb_halvings = 5;  // steps from half a cell down to a 64th

const ArrayLayout& checked(const ArrayLayout& layout, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                           double floor) {
  if (layout.size() == 0) throw std::invalid_argument("field maximum: no transducers, expected some");
  if (!low.allFinite() || !high.allFinite() || !((high - low).minCoeff() > 0.0) || !(floor > 0.0))
    throw std::invalid_argument("field maximum: expected a box and a positive pressure");
  return layout;
}

}  // namespace

/// What a search has found so far.
struct FieldMaximum::Search {
  double floor;
  Peak best;
  Effort effort;

  /// Minimum sum at the centre of a part whose lobe can be higher than the floor and all known pressures.
  float minimum() const { return static_cast<float>((1.0 - beam_sag) * std::max(floor, best.pressure)); }
};

FieldMaximum::FieldMaximum(const ArrayLayout& layout, const Acoustics& acoustics, const Eigen::Vector3d& low,
                           const Eigen::Vector3d& high, double floor)
    : layout_(checked(layout, low, high, floor)),
      acoustics_(acoustics),
      low_(low.cast<float>()),
      high_(high.cast<float>()),
      floor_(floor),
      groups_(layout),
      cells_(fieldCells(layout, acoustics, groups_, low_, high_, floor)) {
  simple_ = std::all_of(layout.normal.begin(), layout.normal.end(),
                        [](const auto& n) { return n == Eigen::Vector3d::UnitZ(); }) &&
            std::all_of(layout.position.begin(), layout.position.end(),
                        [&](const auto& x) { return x.z() == layout.position.front().z(); });
  for (const Eigen::Vector3d& x : layout.position) {
    const Eigen::Vector3d closest = x.cwiseMax(low).cwiseMin(high);
    const double r = std::max((closest - x).norm(), acoustics.transducer_radius);
    nearest_.push_back(static_cast<float>(acoustics.reference_pressure / r));
    const double farthest = (x - low).cwiseAbs().cwiseMax((x - high).cwiseAbs()).norm();
    simple_ = simple_ && acoustics.attenuation * farthest <= 0.5;
  }
}

/// Climbs to the top of a lobe. If no neighbour is higher, the step is halved.
FieldMaximum::Peak FieldMaximum::climb(const DrivenGroups& sources, const Lobe& from, Effort& effort) const {
  static const std::array<Eigen::Vector3f, wide_lane_count> ways = [] {
    std::array<Eigen::Vector3f, wide_lane_count> all;
    std::size_t n = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (const float side : {-1.0f, 1.0f}) all[n++] = side * Eigen::Vector3f::Unit(axis);
    for (int corner = 0; corner < 8; ++corner)
      all[n++] = 0.6f * Eigen::Vector3f(corner & 1 ? 1.0f : -1.0f, corner & 2 ? 1.0f : -1.0f,
                                        corner & 4 ? 1.0f : -1.0f);
    while (n < wide_lane_count) all[n++].setZero();
    return all;
  }();
  Eigen::Vector3f here = from.part.centre, step = from.part.half;
  float pressure = from.pressure;
  ++effort.climbs;
  for (int n = 0, halvings = 0; n < climb_steps && halvings <= climb_halvings; ++n) {
    LanePoints at;
    std::array<Eigen::Vector3f, wide_lane_count> there;
    for (std::size_t i = 0; i < wide_lane_count; ++i) {
      there[i] = (here + step.cwiseProduct(ways[i])).cwiseMax(low_).cwiseMin(high_);
      at.x[i] = there[i].x();
      at.y[i] = there[i].y();
      at.z[i] = there[i].z();
    }
    Lanes amplitude;
    sources.sums(0, at, amplitude);
    effort.evaluations += wide_lane_count;
    std::size_t best = wide_lane_count;
    for (std::size_t i = 0; i < wide_lane_count; ++i) {
      if (amplitude[i] <= pressure) continue;
      pressure = amplitude[i];
      best = i;
    }
    if (best < wide_lane_count) {
      here = there[best];
    } else {
      step *= 0.5f;
      ++halvings;
    }
  }
  return {pressure, here.cast<double>()};
}

/// Those of the open parts in which a higher pressure is still possible, with the sums of their groups.
std::vector<FieldMaximum::Lobe> FieldMaximum::follow(const DrivenGroups& sources, std::size_t depth,
                                                     const std::vector<Part>& open, Search& search) const {
  std::vector<Lobe> found;
  for (std::size_t i = 0; i < open.size(); i += wide_lane_count) {
    LanePoints at;
    for (std::size_t lane = 0; lane < wide_lane_count; ++lane) {
      const Part& part = open[std::min(i + lane, open.size() - 1)];
      at.x[lane] = part.centre.x();
      at.y[lane] = part.centre.y();
      at.z[lane] = part.centre.z();
    }
    Lanes sums;
    sources.sums(depth, at, sums);
    for (std::size_t lane = 0; lane < wide_lane_count && i + lane < open.size(); ++lane)
      if (sums[lane] >= search.minimum()) found.push_back({open[i + lane], sums[lane]});
  }
  search.effort.evaluations += open.size();
  std::stable_sort(found.begin(), found.end(),
                   [](const Lobe& a, const Lobe& b) { return a.pressure > b.pressure; });
  if (found.size() > max_parts) {
    // A part that is not searched counts with the bound of its lobe.
    const Lobe& dropped = found[max_parts];
    const double bound = static_cast<double>(dropped.pressure) / (1.0 - static_cast<double>(beam_sag));
    if (bound > search.best.pressure) search.best = {bound, dropped.part.centre.cast<double>()};
    found.resize(max_parts);
  }
  return found;
}

/// Parts of cells in which the top of a lobe may lie, the highest first.
/// @param strongest largest amplitude of all transducers
std::vector<FieldMaximum::Lobe> FieldMaximum::lobes(const DrivenGroups& sources, float strongest,
                                                    Search& search) const {
  std::vector<Part> open;
  for (const FieldCell& cell : cells_)
    if (strongest * cell.reach >= search.minimum()) open.push_back({cell.centre, cell.half, &cell});
  for (std::size_t depth = groups_.ends.size() - 1;; --depth) {
    std::vector<Lobe> found = follow(sources, depth, open, search);
    if (depth == 0 || found.empty()) return found;
    // The field itself at the most promising parts: parts whose sums are below (1 - beam_sag) of it need not
    // be followed.
    std::vector<Part> promising;
    for (std::size_t i = 0; i < std::min(wide_lane_count, found.size()); ++i)
      promising.push_back(found[i].part);
    for (const Lobe& lobe : follow(sources, 0, promising, search))
      if (lobe.pressure > search.best.pressure)
        search.best = {lobe.pressure, lobe.part.centre.cast<double>()};
    open.clear();
    for (const Lobe& lobe : found)
      if (lobe.pressure >= search.minimum()) split(lobe.part, lobe.part.cell->ratios[depth - 1], open);
  }
}

void FieldMaximum::split(const Part& part, const FieldCell::Ratio& ratio, std::vector<Part>& parts) {
  const Eigen::Vector3f count(ratio[0], ratio[1], ratio[2]);
  const Eigen::Vector3f half = part.half.cwiseQuotient(count);
  const Eigen::Vector3f first = part.centre - part.half + half;
  for (int x = 0; x < ratio[0]; ++x)
    for (int y = 0; y < ratio[1]; ++y)
      for (int z = 0; z < ratio[2]; ++z)
        parts.push_back(
            {first + 2.0f * half.cwiseProduct(Eigen::Vector3i(x, y, z).cast<float>()), half, part.cell});
}

/// The strongest of these places. A field has hundreds: they are compared in single precision.
FieldMaximum::Peak FieldMaximum::atStrongest(const Drive& drive,
                                             const std::vector<Eigen::Vector3d>& places) const {
  if (places.empty()) return {};
  std::vector<Eigen::Vector3f> at;
  at.reserve(places.size());
  for (const Eigen::Vector3d& place : places) at.push_back(place.cast<float>());
  std::size_t strongest = 0;
  float highest = -1.0f;
  const std::vector<std::complex<float>> pressures = pressuresAt(layout_, acoustics_, drive, at);
  for (std::size_t k = 0; k < pressures.size(); ++k) {
    const float pressure = std::abs(pressures[k]);
    if (pressure <= highest) continue;  // NaN counts as higher
    highest = pressure;
    strongest = k;
    if (std::isnan(pressure)) break;
  }
  return {std::abs(pressureAt(layout_, acoustics_, drive, places[strongest])), places[strongest]};
}

FieldMaximum::Peak FieldMaximum::find(const Drive& drive, const std::vector<Eigen::Vector3d>& places,
                                      Effort* effort) const {
  if (drive.phase.size() != layout_.size() || drive.amplitude.size() != layout_.size())
    throw std::invalid_argument("field maximum: drive of " + std::to_string(drive.phase.size()) +
                                " channels, expected " + std::to_string(layout_.size()));
  Search search{floor_, atStrongest(drive, places), {}};
  search.effort.evaluations += places.size();
  double bound = 0.0;
  float strongest = 0.0f;
  for (std::size_t n = 0; n < nearest_.size(); ++n) {
    bound += nearest_[n] * drive.amplitude[n];
    strongest = std::max(strongest, drive.amplitude[n]);
  }
  if (!(bound <= floor_)) climbAll({layout_, acoustics_, groups_, drive, simple_}, strongest, search);
  if (effort != nullptr) *effort = search.effort;
  return search.best;
}

void FieldMaximum::climbAll(const DrivenGroups& sources, float strongest, Search& search) const {
  if (sources.empty()) return;
  std::vector<const Part*> higher;
  const std::vector<Lobe> found = lobes(sources, strongest, search);
  for (const Lobe& lobe : found) {
    if (search.effort.climbs == max_climbs || lobe.pressure < search.minimum()) break;
    // A part beside a higher part lies on the slope to the same top.
    const bool slope = std::any_of(higher.begin(), higher.end(), [&](const Part* part) {
      return ((part->centre - lobe.part.centre).cwiseAbs().array() <=
              1.5f * (part->half + lobe.part.half).array())
          .all();
    });
    higher.push_back(&lobe.part);
    if (slope) continue;
    const Peak top = climb(sources, lobe, search.effort);
    if (top.pressure > search.best.pressure) search.best = top;
  }
}

}  // namespace tactile_clay::ultrasound
