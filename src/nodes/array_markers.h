#pragma once

#include <visualization_msgs/MarkerArray.h>

#include "ultrasound/array_layout.h"

namespace tactile_clay::nodes {

/// Markers for rviz, in coordinate frame `array`: the board of an array, and its transducers as spheres. In
/// each sphere a short line ends at the middle of the transducer's face and points in the direction of
/// radiation.
visualization_msgs::MarkerArrayPtr arrayMarkers(const ultrasound::ArrayLayout& layout);

/// Reads the transducers back from the markers of arrayMarkers(): positions and normals, in the order of the
/// channels.
/// @throws std::runtime_error with one line if the markers do not contain them
ultrasound::ArrayLayout layoutOf(const visualization_msgs::MarkerArray& markers);

}  // namespace tactile_clay::nodes
