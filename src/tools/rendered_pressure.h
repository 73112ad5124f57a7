#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "contact/pressure_field.h"
#include "ultrasound/acoustics.h"
#include "ultrasound/array_layout.h"
#include "ultrasound/focal_points.h"

namespace tactile_clay::tools {

/// How the pressure on the skin is rendered: with focal points (AM), or as a field of patterns that take
/// turns.
struct Rendering {
  bool field = false;
  int count = 8;  // focal points at a time, at most; or patterns
};

/// "points:8" or "field:2".
std::string nameOf(const Rendering& rendering);

/// What a rendering made of contacts: means over the frames that were touched; 0 where none was.
struct RenderedPressure {
  double error = 0.0;  // of the radiation pressure on the skin, at the best common scale: RMS, of the clay's
  double ms = 0.0;     // that a frame of it took: points or samples, and phases
};

/// Renders frames, and measures how well.
class PressureMeter {
 public:
  /// @param layout of transducers (ultrasound::arrayLayouts)
  /// @param array its pose in the world
  PressureMeter(const Rendering& rendering, const std::string& layout, const Eigen::Isometry3d& array);

  /// @param skin of a frame, in the world
  /// @param contacts of the clay on it
  void add(const Skin& skin, const std::vector<SkinForce>& contacts);

  RenderedPressure mean() const;

 private:
  Rendering rendering_;
  ultrasound::ArrayLayout layout_;
  ultrasound::Acoustics air_;
  Eigen::Isometry3f to_array_;
  Eigen::Vector3f centre_;  // of the array, m, world
  ultrasound::FocalPointRenderer renderer_;
  int frames_ = 0;
  RenderedPressure sum_;
};

}  // namespace tactile_clay::tools
