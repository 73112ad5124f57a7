#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "ultrasound/acoustics.h"
#include "ultrasound/transducer_groups.h"

namespace tactile_clay::ultrasound {

/// Largest share by which the beams of groups may be weaker at a corner of a cell than at its centre,
/// computed from the curvature of the beams at their maximum.
constexpr float beam_sag = 0.35f;

/// A part of a box within which the beams of the smallest groups hardly change.
struct FieldCell {
  using Ratio = std::array<std::uint8_t, 3>;  // number of parts of a cell along x, y, z

  Eigen::Vector3f centre, half;  // m; half the edge lengths
  float reach = 0.0f;            // Pa, at most, with the whole array at full drive
  std::vector<Ratio> ratios;     // by depth: into how many parts a part of depth + 1 is divided
};

/// Divides a box into cells, and these into parts for the groups of each depth. There are no cells where the
/// pressure of the whole array at full drive is below the floor.
/// @param low, high corners of the box, m
/// @param floor Pa
std::vector<FieldCell> fieldCells(const ArrayLayout& layout, const Acoustics& acoustics,
                                  const TransducerGroups& groups, const Eigen::Vector3f& low,
                                  const Eigen::Vector3f& high, double floor);

}  // namespace tactile_clay::ultrasound
