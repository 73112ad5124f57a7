#pragma once

#include <string>
#include <vector>

#include "tools/facing_skin.h"
#include "ultrasound/acoustics.h"
#include "ultrasound/array_layout.h"
#include "ultrasound/field_solver.h"
#include "ultrasound/focal_points.h"

namespace tactile_clay::tools {

struct Array {
  ultrasound::ArrayLayout layout;
  ultrasound::Acoustics air;
};

/// A way to render, with what it keeps from frame to frame and what came of it, one number a frame.
struct ModulationWay {
  std::string name;
  ultrasound::FocalPointConfig config;
  ultrasound::FieldSolverOptions options;
  ultrasound::FocalPointRenderer renderer;
  std::vector<ultrasound::Drive> before;

  std::vector<double> points;
  std::vector<double> coverage;           // share of the contact force on skin within 6 dB of the strongest
  std::vector<double> error, weighted;    // shapeError of what is rendered
  std::vector<double> pressure, maximum;  // Pa, mean by contact force: as played, and at full drive
  std::vector<double> force;              // N, of the sound on that skin while it is on
  std::vector<double> vibration;          // dB above what is just felt (FeltForce), where that is known
  std::vector<double> touch;              // N, of a steady touch that is felt as strong, where that is known
  std::vector<double> cost;               // s, of the field solver
};

/// Phases have 32 levels.
ModulationWay pointsWay(const std::string& name, ultrasound::Modulation modulation);
ModulationWay fieldWay(const std::string& name, const ultrasound::FieldSolverOptions& options,
                       const ultrasound::FocalPointConfig& config);

/// Renders a frame, and measures it by the true field of each instant of a period.
/// @param pressed samples, frame of the array
/// @param all of the skin around them too
/// @param skin where it is measured; none: it is only rendered
void renderFrame(const Array& array, const Samples& pressed, const Samples& all, const RefinedSkin* skin,
                 ModulationWay& way);

/// Forgets the frames, as at the start of another run, but not what came of them.
void startAnew(ModulationWay& way);

/// Prints a table of the means, a row each.
void printTable(std::vector<ModulationWay>& ways);

}  // namespace tactile_clay::tools
