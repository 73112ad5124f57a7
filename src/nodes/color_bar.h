#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <Eigen/Core>
#include <string>

namespace tactile_clay::nodes {

/// Colour of a pressure: from yellow over orange and red to dark purple. The colours grow darker towards the
/// full scale, so that they can also be distinguished in grey.
/// @param share of the full scale, 0-1
Eigen::Vector3f pressureColor(float share);

/// An upright bar with the colours of pressure, and numbers beside it.
struct ColorBar {
  std::string name;                     // namespace of its markers
  std::string title;                    // with the unit
  double full_scale;                    // in that unit
  Eigen::Vector3f foot, width, height;  // m; numbers are on the side to which width points
  Eigen::Vector3f title_at;             // m
};

/// @param frame coordinate frame of the bar
void addColorBar(visualization_msgs::MarkerArray& markers, const ColorBar& bar, const std::string& frame);

}  // namespace tactile_clay::nodes
