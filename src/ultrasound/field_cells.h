#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "ultrasound/acoustics.h"
#include "ultrasound/transducer_groups.h"

namespace tactile_clay::ultrasound {

/// Share by which the beams of groups may fall from a cell's centre to its corner, by their curvature at the
/// top.
constexpr float beam_sag = 0.35f;

/// A part of a box within which the beams of the smallest groups hardly change.
struct FieldCell {
  using Ratio = std::array<std::uint8_t, 3>;  // parts of a cell along x, y, z

  Eigen::Vector3f centre, half;  // m
  float reach = 0.0f;            // Pa, at most, with the whole array at full drive
  std::vector<Ratio> ratios;     // into how many each of its cells is divided for the groups of a depth
};

/// Divides a box into cells, and these into parts for groups of each depth. Where the whole array at full
/// drive stays below the floor are none.
/// @param low, high corners of the box, m
/// @param floor Pa
std::vector<FieldCell> fieldCells(const ArrayLayout& layout, const Acoustics& acoustics,
                                  const TransducerGroups& groups, const Eigen::Vector3f& low,
                                  const Eigen::Vector3f& high, double floor);

}  // namespace tactile_clay::ultrasound
