#pragma once

#include <string>
#include <vector>

#include "clay/clay.h"
#include "scene/shape.h"

namespace tactile_clay::tools {

/// A moment of a measurement: how deep a tool is in a sample of clay, and what the clay presses it with.
struct PressSample {
  double time;   // s
  double depth;  // m, of the tool's lowest point under the top of the sample as it was at first
  double force;  // N, of the clay on the tool, upward
};
using PressCurve = std::vector<PressSample>;

/// Reads `time,depth,force` in s, m and N, one moment a line; a first line without numbers is a heading, `#`
/// starts a comment.
/// @throws std::runtime_error with one line "FILE:LINE: what was found, what was expected"
PressCurve readPressCurve(const std::string& file);

/// What was pressed with what. The sample stands on a table; the tool comes from above and is moved
/// vertically along the middle of the sample.
struct PressSetup {
  enum class Tool { disc, sphere, plate };

  Tool tool = Tool::disc;
  double radius = 0.008;                                                      // m, of disc or sphere
  scene::Shape sample{scene::Shape::Kind::box, {0.06, 0.06, 0.04}, nullptr};  // box or cylinder
  double spacing = 0.004;                                                     // m, between particles, about
  clay::Budget budget;

  double height() const;  // m, of the sample
  /// m, between particles, so that the height is a whole number of layers
  double fittedSpacing() const;
  /// m^2, of the tool that presses when it is so deep
  double area(double depth) const;
};

/// What does not fit together.
/// @throws std::runtime_error with one line: what was found, what was expected
void check(const PressSetup& setup, const PressCurve& curve);

/// The time from which to which a force is a mean.
struct Window {
  double from, to;  // s
};
/// Those in which the clay is compared with a curve: its frames, from the first to the last moment.
std::vector<Window> windowsOf(const PressCurve& curve);

/// N, mean of a curve in each window; straight between its moments.
std::vector<double> measuredForces(const PressCurve& curve, const std::vector<Window>& windows);

/// N, of the clay on the tool in each window, as the tool moves along the depths of the curve.
std::vector<double> modelForces(const PressSetup& setup, const clay::Material& material,
                                const PressCurve& curve, const std::vector<Window>& windows);

}  // namespace tactile_clay::tools
