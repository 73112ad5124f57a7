#pragma once

#include <vector>

namespace tactile_clay::rviz_plugins {

/// A label as the camera sees it, in any unit of length: its middle, its lower edge, its size.
struct LabelBox {
  float middle, bottom, width, height;
};

/// How far each label has to rise so that none lies over another or over an obstacle. Those at the bottom
/// stay where they are; of two at one height the first one. Each rises no farther than it must above what
/// stays below.
std::vector<float> risesOf(const std::vector<LabelBox>& labels, const std::vector<LabelBox>& obstacles = {});

}  // namespace tactile_clay::rviz_plugins
