#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "clay/contact/contact.h"
#include "values/skin.h"

namespace tactile_clay::clay {

/// Sample that may be part of the skin at a place.
struct NearSample {
  std::uint32_t sample;
  float nearest;  // m^2, the minimum squared distance to it in the step
};

/// The tangent plane of one side of the skin near a place.
struct SkinPlane {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit
  float distance = 0.0f, before = 0.0f;  // m, of the place from it at the end and the start of the step
  Eigen::Vector3f drift = Eigen::Vector3f::Zero();  // m, displacement of the skin in the step
};

/// Moves the samples that face as the nearest does from `rest`, which must not be empty, to `side`.
void takeSide(const Skin& skin, std::vector<NearSample>& rest, std::vector<NearSample>& side);

/// The tangent plane of a side of the skin near x, the mean of its samples by weights that fall with the
/// distance to the particle's way; these are added to `shares`.
/// @param radius m, R, where weights vanish
/// @param dt s, of the step
SkinPlane planeOf(const Skin& skin, const std::vector<NearSample>& side, const Eigen::Vector3f& x,
                  float radius, float dt, std::vector<SampleShare>& shares);

}  // namespace tactile_clay::clay
