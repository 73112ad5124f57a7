#pragma once

#include <Eigen/Core>
#include <vector>

#include "surface/triangle_mesh.h"

namespace tactile_clay::nodes {

/// A hand as skin for the eye, and the pressure on it.
struct PaintedHand {
  surface::TriangleMesh mesh;   // m, in world
  std::vector<float> pressure;  // Pa, at each corner
};

/// Skin that touches.
struct Touch {
  std::vector<Eigen::Vector3f> position, normal;  // m, unit, in world
  std::vector<float> pressure;                    // Pa
};

constexpr float touch_share = 0.02f;  // of the full scale, from which skin touches

Eigen::Vector3f skinColor();

/// @param share of the full scale; the colours of pressure rise out of that of the skin
Eigen::Vector3f painted(float share, const Eigen::Vector3f& skin);

/// Square of the distance to the closest of `places`, m^2; infinite where there are none.
float closestSquare(const Eigen::Vector3f& at, const std::vector<Eigen::Vector3f>& places);

/// Whether a place is nearer than `reach`, m.
bool isNear(const Eigen::Vector3f& at, const std::vector<Eigen::Vector3f>& places, float reach);

}  // namespace tactile_clay::nodes
