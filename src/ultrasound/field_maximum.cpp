#include "ultrasound/field_maximum.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <string>

#include "ultrasound/piston_source.h"

namespace tactile_clay::ultrasound {
namespace {

constexpr std::size_t smallest_group = 4;  // transducers
/// Share by which the beams of groups may fall from a cell's centre to its corner, by their curvature at the
/// top.
constexpr float sag = 0.35f;
constexpr std::size_t most_parts = 4096;  // of cells that are followed, at a depth
constexpr std::size_t most_climbs = 12;
constexpr int climb_steps = 24, climb_halvings = 5;  // from half a cell down to a 64th

/// Sum over groups of |p| at sixteen points.
template <bool simple>
TACTILE_CLAY_INLINE Lanes groupSum(const PistonSource* sources, const std::uint32_t* ends, std::size_t groups,
                                   const PistonConstants& air, const LanePoints& at) {
  Lanes total{};
  const Lanes height = at.z - sources[0].z;
  const Lanes height_squared = height * height;
  std::uint32_t n = 0;
  for (std::size_t group = 0; group < groups; ++group) {
    Lanes re{};
    Lanes im{};
    for (; n < ends[group]; ++n) addWave<simple>(sources[n], air, at, height, height_squared, re, im);
    const Lanes squared = larger(re * re + im * im, Lanes{} + 1e-30f);
    total += squared * inverseRoot(squared);
  }
  return total;
}

TACTILE_CLAY_CLONES void sumSimple(const PistonSource* sources, const std::uint32_t* ends, std::size_t groups,
                                   const PistonConstants& air, const LanePoints& at, Lanes* sums) {
  *sums = groupSum<true>(sources, ends, groups, air, at);
}

TACTILE_CLAY_CLONES void sumAny(const PistonSource* sources, const std::uint32_t* ends, std::size_t groups,
                                const PistonConstants& air, const LanePoints& at, Lanes* sums) {
  *sums = groupSum<false>(sources, ends, groups, air, at);
}

/// Of a group at a point: sum of amplitudes a, and of a s and a s s for the unit vectors s from its
/// transducers.
struct Beam {
  float a = 0.0f;
  Eigen::Vector3f s = Eigen::Vector3f::Zero();
  Eigen::Matrix3f ss = Eigen::Matrix3f::Zero();

  void add(const Beam& other) {
    a += other.a;
    s += other.s;
    ss += other.ss;
  }
  /// a times the covariance of s.
  Eigen::Matrix3f spread() const { return a > 0.0f ? Eigen::Matrix3f(ss - s * s.transpose() / a) : ss; }
};

}  // namespace

/// What a search has found so far.
struct FieldMaximum::Search {
  double floor;
  Peak best;
  Effort effort;

  /// What the centre of a part has at least where its lobe is higher than all that is known.
  float least() const { return static_cast<float>((1.0 - sag) * std::max(floor, best.pressure)); }
};

/// The transducers that a drive drives, in order, and the ends of their groups at each depth.
struct FieldMaximum::Sources {
  std::vector<PistonSource> source;
  std::vector<std::vector<std::uint32_t>> ends;
  PistonConstants air;
  bool simple;

  /// \param depth of the groups; 0: the whole array
  Lanes sums(std::size_t depth, const LanePoints& at) const {
    Lanes result;
    (simple ? sumSimple : sumAny)(source.data(), ends[depth].data(), ends[depth].size(), air, at, &result);
    return result;
  }
};

FieldMaximum::FieldMaximum(const ArrayLayout& layout, const Acoustics& acoustics, const Eigen::Vector3d& low,
                           const Eigen::Vector3d& high, double floor)
    : layout_(layout),
      acoustics_(acoustics),
      low_(low.cast<float>()),
      high_(high.cast<float>()),
      floor_(floor),
      order_(layout.size()) {
  if (layout.size() == 0) throw std::invalid_argument("field maximum: no transducers, expected some");
  if (!low.allFinite() || !high.allFinite() || !((high - low).minCoeff() > 0.0) || !(floor > 0.0))
    throw std::invalid_argument("field maximum: expected a box and a positive pressure");
  std::iota(order_.begin(), order_.end(), 0u);
  std::size_t depths = 1;
  while (smallest_group << (depths - 1) < layout.size()) ++depths;
  ends_.resize(depths);
  order(order_.begin(), order_.end(), 0);

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

  divide(0.5f * (low_ + high_), 0.5f * (high_ - low_));
}

/// Halves a range of transducers along its longest side, and so on.
void FieldMaximum::order(std::vector<std::uint32_t>::iterator begin, std::vector<std::uint32_t>::iterator end,
                         std::size_t depth) {
  ends_[depth].push_back(static_cast<std::uint32_t>(end - order_.begin()));
  if (depth + 1 == ends_.size()) return;
  Eigen::Vector3d low = layout_.position[*begin], high = low;
  for (auto n = begin; n != end; ++n) {
    low = low.cwiseMin(layout_.position[*n]);
    high = high.cwiseMax(layout_.position[*n]);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](std::uint32_t a, std::uint32_t b) {
    const double x = layout_.position[a][axis], y = layout_.position[b][axis];
    return x < y || (x == y && a < b);
  });
  order(begin, middle, depth + 1);
  order(middle, end, depth + 1);
}

/// Spreads of the beams of all groups of each depth at a point, summed with their amplitudes as weights, Pa.
struct FieldMaximum::Spreads {
  std::vector<Eigen::Matrix3f> at_depth;
  float reach = 0.0f;  // sum of amplitudes

  /// Share by which the beams fall at the worst corner of a box.
  float fall(std::size_t depth, const Eigen::Vector3f& half, float k) const {
    return 0.5f * k * k * half.dot(at_depth[depth].cwiseAbs() * half) / std::max(reach, 1e-20f);
  }
  Eigen::Index widest(std::size_t depth, const Eigen::Vector3f& half) const {
    Eigen::Index axis = 0;
    half.cwiseAbs2().cwiseProduct(at_depth[depth].diagonal()).maxCoeff(&axis);
    return axis;
  }
};

/// \param slack m, by which transducers are taken to be nearer to the point's direction than they are
FieldMaximum::Spreads FieldMaximum::spreads(const Eigen::Vector3f& centre, float slack) const {
  const auto radius = static_cast<float>(acoustics_.transducer_radius);
  const auto piston = static_cast<float>(std::pow(acoustics_.wavenumber() * acoustics_.transducer_radius, 2));
  std::vector<Beam> beams(order_.size());
  Spreads result;
  for (std::size_t n = 0; n < order_.size(); ++n) {
    const Eigen::Vector3f way = centre - layout_.position[order_[n]].cast<float>();
    const float r = std::max(way.norm(), radius);
    const Eigen::Vector3f s = way / r;
    const float ahead = std::min(s.dot(layout_.normal[order_[n]].cast<float>()) + slack / r, 1.0f);
    if (!(ahead > 0.0f)) continue;
    Beam& beam = beams[n];
    beam.a = static_cast<float>(acoustics_.reference_pressure) / r *
             pistonDirectivity(piston * (1.0f - ahead * ahead));
    beam.s = beam.a * s;
    beam.ss = beam.s * s.transpose();
    result.reach += beam.a;
  }
  for (const std::vector<std::uint32_t>& ends : ends_) {
    Eigen::Matrix3f spread = Eigen::Matrix3f::Zero();
    std::uint32_t n = 0;
    for (const std::uint32_t end : ends) {
      Beam group;
      for (; n < end; ++n) group.add(beams[n]);
      spread += group.spread();
    }
    result.at_depth.push_back(spread);
  }
  return result;
}

/// Divides a box into cells. Where the whole array at full drive stays below the floor are none.
void FieldMaximum::divide(const Eigen::Vector3f& centre, const Eigen::Vector3f& half) {
  const auto k = static_cast<float>(acoustics_.wavenumber());
  const Spreads spreads = this->spreads(centre, half.norm());
  std::size_t depth = ends_.size() - 1;
  if (spreads.fall(depth, half, k) > sag) {
    const Eigen::Index axis = spreads.widest(depth, half);
    Eigen::Vector3f part = half;
    part[axis] *= 0.5f;
    for (const float side : {-1.0f, 1.0f}) {
      Eigen::Vector3f at = centre;
      at[axis] += side * part[axis];
      divide(at, part);
    }
    return;
  }
  if (spreads.reach < (1.0f - sag) * static_cast<float>(floor_)) return;
  Cell cell{centre, half, spreads.reach, std::vector<Ratio>(ends_.size(), Ratio{1, 1, 1})};
  Eigen::Vector3f parts = half;
  while (depth-- > 0) {
    Ratio& ratio = cell.ratios[depth];
    Eigen::Vector3f part = parts;
    while (spreads.fall(depth, part, k) > sag) {
      const Eigen::Index axis = spreads.widest(depth, part);
      const std::uint8_t count = ++ratio[static_cast<std::size_t>(axis)];
      part[axis] = parts[axis] / static_cast<float>(count);
    }
    parts = part;
  }
  cells_.push_back(std::move(cell));
}

FieldMaximum::Sources FieldMaximum::sources(const Drive& drive) const {
  Sources result{
      {}, std::vector<std::vector<std::uint32_t>>(ends_.size()), PistonConstants(acoustics_), simple_};
  std::vector<std::uint32_t> driven(order_.size() + 1, 0);  // of the first n in order
  for (std::size_t n = 0; n < order_.size(); ++n) {
    const std::size_t t = order_[n];
    if (drive.amplitude[t] != 0.0f) {
      result.source.push_back(pistonSource(layout_, acoustics_, drive, t));
    }
    driven[n + 1] = static_cast<std::uint32_t>(result.source.size());
  }
  for (std::size_t depth = 0; depth < ends_.size(); ++depth)
    for (const std::uint32_t end : ends_[depth]) result.ends[depth].push_back(driven[end]);
  return result;
}

/// Uphill to the top of a lobe, in steps that halve where no neighbour is higher.
FieldMaximum::Peak FieldMaximum::climb(const Sources& sources, const Lobe& from, Effort& effort) const {
  static const std::array<Eigen::Vector3f, lane_count> ways = [] {
    std::array<Eigen::Vector3f, lane_count> all;
    std::size_t n = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (const float side : {-1.0f, 1.0f}) all[n++] = side * Eigen::Vector3f::Unit(axis);
    for (int corner = 0; corner < 8; ++corner)
      all[n++] = 0.6f * Eigen::Vector3f(corner & 1 ? 1.0f : -1.0f, corner & 2 ? 1.0f : -1.0f,
                                        corner & 4 ? 1.0f : -1.0f);
    while (n < lane_count) all[n++].setZero();
    return all;
  }();
  Eigen::Vector3f here = from.part.centre, step = from.part.half;
  float pressure = from.pressure;
  ++effort.climbs;
  for (int n = 0, halvings = 0; n < climb_steps && halvings <= climb_halvings; ++n) {
    LanePoints at;
    std::array<Eigen::Vector3f, lane_count> there;
    for (std::size_t i = 0; i < lane_count; ++i) {
      there[i] = (here + step.cwiseProduct(ways[i])).cwiseMax(low_).cwiseMin(high_);
      at.x[i] = there[i].x();
      at.y[i] = there[i].y();
      at.z[i] = there[i].z();
    }
    const Lanes amplitude = sources.sums(0, at);
    effort.evaluations += lane_count;
    std::size_t best = lane_count;
    for (std::size_t i = 0; i < lane_count; ++i) {
      if (amplitude[i] <= pressure) continue;
      pressure = amplitude[i];
      best = i;
    }
    if (best < lane_count) {
      here = there[best];
    } else {
      step *= 0.5f;
      ++halvings;
    }
  }
  return {pressure, here.cast<double>()};
}

/// The parts of cells that a search is still interested in, and the sums of their groups.
std::vector<FieldMaximum::Lobe> FieldMaximum::follow(const Sources& sources, std::size_t depth,
                                                     const std::vector<Part>& open, Search& search) const {
  std::vector<Lobe> found;
  for (std::size_t i = 0; i < open.size(); i += lane_count) {
    LanePoints at;
    for (std::size_t lane = 0; lane < lane_count; ++lane) {
      const Part& part = open[std::min(i + lane, open.size() - 1)];
      at.x[lane] = part.centre.x();
      at.y[lane] = part.centre.y();
      at.z[lane] = part.centre.z();
    }
    const Lanes sums = sources.sums(depth, at);
    for (std::size_t lane = 0; lane < lane_count && i + lane < open.size(); ++lane)
      if (sums[lane] >= search.least()) found.push_back({open[i + lane], sums[lane]});
  }
  search.effort.evaluations += open.size();
  std::stable_sort(found.begin(), found.end(),
                   [](const Lobe& a, const Lobe& b) { return a.pressure > b.pressure; });
  if (found.size() > most_parts) {
    // What is not looked into counts as loud as it can be.
    const Lobe& dropped = found[most_parts];
    if (dropped.pressure > search.best.pressure)
      search.best = {dropped.pressure, dropped.part.centre.cast<double>()};
    found.resize(most_parts);
  }
  return found;
}

/// Parts of cells that may hold the top of a lobe, the highest first. \param strongest amplitude of a
/// transducer
std::vector<FieldMaximum::Lobe> FieldMaximum::lobes(const Sources& sources, float strongest,
                                                    Search& search) const {
  std::vector<Part> open;
  for (const Cell& cell : cells_)
    if (strongest * cell.reach >= search.least()) open.push_back({cell.centre, cell.half, &cell});
  for (std::size_t depth = ends_.size() - 1;; --depth) {
    const std::vector<Lobe> found = follow(sources, depth, open, search);
    if (depth == 0 || found.empty()) return found;
    // The field itself at the most promising parts: what is below it need not be followed.
    std::vector<Part> promising;
    for (std::size_t i = 0; i < std::min(lane_count, found.size()); ++i) promising.push_back(found[i].part);
    for (const Lobe& lobe : follow(sources, 0, promising, search))
      if (lobe.pressure > search.best.pressure)
        search.best = {lobe.pressure, lobe.part.centre.cast<double>()};
    open.clear();
    for (const Lobe& lobe : found)
      if (lobe.pressure >= search.least()) split(lobe.part, lobe.part.cell->ratios[depth - 1], open);
  }
}

void FieldMaximum::split(const Part& part, const Ratio& ratio, std::vector<Part>& parts) {
  const Eigen::Vector3f count(ratio[0], ratio[1], ratio[2]);
  const Eigen::Vector3f half = part.half.cwiseQuotient(count);
  const Eigen::Vector3f first = part.centre - part.half + half;
  for (int x = 0; x < ratio[0]; ++x)
    for (int y = 0; y < ratio[1]; ++y)
      for (int z = 0; z < ratio[2]; ++z)
        parts.push_back(
            {first + 2.0f * half.cwiseProduct(Eigen::Vector3i(x, y, z).cast<float>()), half, part.cell});
}

FieldMaximum::Peak FieldMaximum::find(const Drive& drive, const std::vector<Eigen::Vector3d>& places,
                                      Effort* effort) const {
  if (drive.phase.size() != layout_.size() || drive.amplitude.size() != layout_.size())
    throw std::invalid_argument("field maximum: drive of " + std::to_string(drive.phase.size()) +
                                " channels, expected " + std::to_string(layout_.size()));
  Search search{floor_, {}, {}};
  for (const Eigen::Vector3d& place : places) {
    const double pressure = std::abs(pressureAt(layout_, acoustics_, drive, place));
    if (!(pressure <= search.best.pressure)) search.best = {pressure, place};
  }
  search.effort.evaluations += places.size();
  double bound = 0.0;
  float strongest = 0.0f;
  for (std::size_t n = 0; n < nearest_.size(); ++n) {
    bound += nearest_[n] * drive.amplitude[n];
    strongest = std::max(strongest, drive.amplitude[n]);
  }
  if (!(bound <= floor_)) climbAll(sources(drive), strongest, search);
  if (effort != nullptr) *effort = search.effort;
  return search.best;
}

void FieldMaximum::climbAll(const Sources& sources, float strongest, Search& search) const {
  if (sources.source.empty()) return;
  std::vector<const Part*> higher;
  const std::vector<Lobe> found = lobes(sources, strongest, search);
  for (const Lobe& lobe : found) {
    if (search.effort.climbs == most_climbs || lobe.pressure < search.least()) break;
    // A part beside a higher one lies on the slope to the same top.
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
