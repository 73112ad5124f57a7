#pragma once

#include <tactile_clay/FocalPointArray.h>

#include <vector>

namespace tactile_clay::rviz_plugins {

/// The points of a message that a display shows: all focal points. A field has hundreds of samples of skin
/// instead of focal points. Of these it is the local maxima: samples whose wanted pressure is above 0 and is
/// not exceeded by that of any other sample within the width of a focus. Points that are not finite are left
/// out.
std::vector<tactile_clay::FocalPoint> shownPoints(const tactile_clay::FocalPointArray& message);

}  // namespace tactile_clay::rviz_plugins
