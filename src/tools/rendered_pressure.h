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
  int count = 8;  // maximum number of focal points at a time; or number of patterns
};

/// "points:8" or "field:2".
std::string nameOf(const Rendering& rendering);

/// Results of a rendering: means over the frames with contact; 0 if there were none.
struct RenderedPressure {
  /// Error of the radiation pressure on the skin at the best common scale: RMS, over that of the clay's
  /// pressure.
  double error = 0.0;
  double ms = 0.0;  // duration of a frame: points or samples, and phases
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
