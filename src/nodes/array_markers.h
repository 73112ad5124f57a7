#pragma once

#include <visualization_msgs/MarkerArray.h>

#include "ultrasound/array_layout.h"

namespace tactile_clay::nodes {

/// The board of an array and its transducers, in frame `array`, for rviz.
visualization_msgs::MarkerArrayPtr arrayMarkers(const ultrasound::ArrayLayout& layout);

}  // namespace tactile_clay::nodes
