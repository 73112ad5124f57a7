#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "contact/pressure_field.h"
#include "nodes/conversions.h"

namespace tactile_clay::tools {

using Samples = std::vector<contact::PressureSample>;

/// The pressed samples and the bare samples around them, in the frame of the array.
/// @param pressed already in the frame of the array
Samples facingSkin(const Samples& pressed, const Skin& in_world, const Eigen::Isometry3f& to_array);

/// The skin that faces the array around a contact, at its samples and halfway between neighbours.
struct RefinedSkin {
  std::vector<Eigen::Vector3f> position, normal;  // m; outward, unit
  std::vector<double> pressure, area, weight;
};
RefinedSkin refined(const Samples& samples);

/// The ShapeError of a rendering.
/// @param rendered radiation pressure at each place of the skin
/// @param weighted whether places also count by the weights of the samples
double shapeError(const RefinedSkin& skin, const std::vector<float>& rendered, bool weighted);

}  // namespace tactile_clay::tools
