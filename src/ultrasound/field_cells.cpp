#include "ultrasound/field_cells.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ultrasound/piston_wave.h"

namespace tactile_clay::ultrasound {
namespace {

struct Division {
  const ArrayLayout& layout;
  const Acoustics& acoustics;
  const TransducerGroups& groups;
  double floor;  // Pa
};

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

/// Spreads of the beams of all groups of each depth at a point, summed with their amplitudes as weights, Pa.
struct Spreads {
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

/// @param slack m, by which transducers are taken to be nearer to the point's direction than they are
Spreads spreadsAt(const Division& box, const Eigen::Vector3f& centre, float slack) {
  const auto radius = static_cast<float>(box.acoustics.transducer_radius);
  const auto piston =
      static_cast<float>(std::pow(box.acoustics.wavenumber() * box.acoustics.transducer_radius, 2));
  std::vector<Beam> beams(box.groups.order.size());
  Spreads result;
  for (std::size_t n = 0; n < box.groups.order.size(); ++n) {
    const Eigen::Vector3f way = centre - box.layout.position[box.groups.order[n]].cast<float>();
    const float r = std::max(way.norm(), radius);
    const Eigen::Vector3f s = way / r;
    const float ahead =
        std::min(s.dot(box.layout.normal[box.groups.order[n]].cast<float>()) + slack / r, 1.0f);
    if (!(ahead > 0.0f)) continue;
    Beam& beam = beams[n];
    beam.a = static_cast<float>(box.acoustics.reference_pressure) / r *
             pistonDirectivity(piston * (1.0f - ahead * ahead));
    beam.s = beam.a * s;
    beam.ss = beam.s * s.transpose();
    result.reach += beam.a;
  }
  for (const std::vector<std::uint32_t>& ends : box.groups.ends) {
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

void divide(const Division& box, const Eigen::Vector3f& centre, const Eigen::Vector3f& half,
            std::vector<FieldCell>& cells) {
  const auto k = static_cast<float>(box.acoustics.wavenumber());
  const Spreads spreads = spreadsAt(box, centre, half.norm());
  std::size_t depth = box.groups.ends.size() - 1;
  if (spreads.fall(depth, half, k) > beam_sag) {
    const Eigen::Index axis = spreads.widest(depth, half);
    Eigen::Vector3f part = half;
    part[axis] *= 0.5f;
    for (const float side : {-1.0f, 1.0f}) {
      Eigen::Vector3f at = centre;
      at[axis] += side * part[axis];
      divide(box, at, part, cells);
    }
    return;
  }
  if (spreads.reach < (1.0f - beam_sag) * static_cast<float>(box.floor)) return;
  FieldCell cell{centre, half, spreads.reach,
                 std::vector<FieldCell::Ratio>(box.groups.ends.size(), FieldCell::Ratio{1, 1, 1})};
  Eigen::Vector3f parts = half;
  while (depth-- > 0) {
    FieldCell::Ratio& ratio = cell.ratios[depth];
    Eigen::Vector3f part = parts;
    while (spreads.fall(depth, part, k) > beam_sag) {
      const Eigen::Index axis = spreads.widest(depth, part);
      const std::uint8_t count = ++ratio[static_cast<std::size_t>(axis)];
      part[axis] = parts[axis] / static_cast<float>(count);
    }
    parts = part;
  }
  cells.push_back(std::move(cell));
}

}  // namespace

std::vector<FieldCell> fieldCells(const ArrayLayout& layout, const Acoustics& acoustics,
                                  const TransducerGroups& groups, const Eigen::Vector3f& low,
                                  const Eigen::Vector3f& high, double floor) {
  std::vector<FieldCell> cells;
  divide({layout, acoustics, groups, floor}, 0.5f * (low + high), 0.5f * (high - low), cells);
  return cells;
}

}  // namespace tactile_clay::ultrasound
