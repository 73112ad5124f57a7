#pragma once

#include <string>
#include <vector>

#include "clay/clay.h"
#include "scene/shape.h"

namespace tactile_clay::tools {

/// A moment of a measurement: depth of a tool in a sample of clay, and force of the clay on the tool.
struct PressSample {
  double time;   // s
  double depth;  // m, of the tool's lowest point below the initial top of the sample
  double force;  // N, of the clay on the tool, upward
};
using PressCurve = std::vector<PressSample>;

/// Reads `time,depth,force` in s, m and N, one moment per line. A first line without numbers is a heading,
/// and `#` starts a comment.
/// @throws std::runtime_error with one line "FILE:LINE: what was found, what was expected"
PressCurve readPressCurve(const std::string& file);

/// The sample that was pressed, and the tool. The sample stands on a table; the tool comes from above and
/// moves vertically along the middle of the sample.
struct PressSetup {
  enum class Tool { disc, sphere, plate };

  Tool tool = Tool::disc;
  double radius = 0.008;                                                      // m, of disc or sphere
  scene::Shape sample{scene::Shape::Kind::box, {0.06, 0.06, 0.04}, nullptr};  // box or cylinder
  double spacing = 0.004;  // m, between particles, approximately
  clay::Budget budget;

  double height() const;  // m, of the sample
  /// Spacing of particles, m, with which the height is a whole number of layers.
  double fittedSpacing() const;
  /// Area of the tool, m^2, that presses at a depth.
  double area(double depth) const;
};

/// Checks that a setup and a curve fit together.
/// @throws std::runtime_error with one line: what was found, what was expected
void check(const PressSetup& setup, const PressCurve& curve);

/// A time interval over which the mean of a force is taken.
struct Window {
  double from, to;  // s
};
/// The windows in which the clay is compared with a curve: its frames, from the first to the last moment.
std::vector<Window> windowsOf(const PressCurve& curve);

/// Mean force of a curve in each window, N; the curve is linear between its moments.
std::vector<double> measuredForces(const PressCurve& curve, const std::vector<Window>& windows);

/// Force of the clay on the tool in each window, N, if the tool moves along the depths of the curve.
std::vector<double> modelForces(const PressSetup& setup, const clay::Material& material,
                                const PressCurve& curve, const std::vector<Window>& windows);

}  // namespace tactile_clay::tools
