#pragma once

#include <Eigen/Core>
#include <vector>

#include "surface/triangle_mesh.h"

namespace tactile_clay::nodes {

/// A hand as skin for display, and the pressure on it.
struct PaintedHand {
  surface::TriangleMesh mesh;   // m, in world
  std::vector<float> pressure;  // Pa, at each corner
};

/// Skin samples that touch.
struct Touch {
  std::vector<Eigen::Vector3f> position, normal;  // m, unit, in world
  std::vector<float> pressure;                    // Pa
};

constexpr float touch_share = 0.02f;  // share of the full scale from which skin touches

Eigen::Vector3f skinColor();

/// Colour of the skin, which goes over into the colours of pressure.
/// @param share of the full scale
Eigen::Vector3f painted(float share, const Eigen::Vector3f& skin);

/// Whether a place is nearer than `reach`, m.
bool isNear(const Eigen::Vector3f& at, const std::vector<Eigen::Vector3f>& places, float reach);

}  // namespace tactile_clay::nodes
