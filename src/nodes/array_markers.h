#pragma once

#include <visualization_msgs/MarkerArray.h>

#include "ultrasound/array_layout.h"

namespace tactile_clay::nodes {

/// The board of an array and its transducers, in frame `array`, for rviz: spheres, and within each a short
/// line that ends at the middle of its face and points the way it radiates.
visualization_msgs::MarkerArrayPtr arrayMarkers(const ultrasound::ArrayLayout& layout);

/// The transducers that arrayMarkers() shows, in the order of their channels: positions and normals, as they
/// were.
/// @throws std::runtime_error with one line where the markers do not tell them
ultrasound::ArrayLayout layoutOf(const visualization_msgs::MarkerArray& markers);

}  // namespace tactile_clay::nodes
