#pragma once

#include <Eigen/Core>
#include <vector>

namespace tactile_clay::clay {

/// Points x with normal . x >= least.
struct HalfSpace {
  Eigen::Vector3f normal;  // unit
  float least;             // m
};

/// The shortest way from the origin into all half-spaces, as lengths along their normals. None is negative,
/// and three at most are not zero: these conditions (Karush, Kuhn and Tucker) have one solution only.
/// \return empty: there is no way, or none that is shorter than `most`, m, or only one along normals that
/// all but depend on each other
std::vector<float> shortestInto(const std::vector<HalfSpace>& spaces, float most);

}  // namespace tactile_clay::clay
