#pragma once

#include <vector>

namespace tactile_clay::rviz_plugins {

/// A label as the camera sees it, in any unit of length: its middle, its lower edge, its size.
struct LabelBox {
  float middle, bottom, width, height;
};

/// How far each label has to rise so that none lies over another one or over an obstacle. The lowest labels
/// stay where they are; if two are at one height, the first one stays. Each label rises no farther than it
/// must, above those that stay below it.
std::vector<float> risesOf(const std::vector<LabelBox>& labels, const std::vector<LabelBox>& obstacles = {});

}  // namespace tactile_clay::rviz_plugins
