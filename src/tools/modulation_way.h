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
  bool on_skin = false;  // whether pressure is measured on rigid skin (acoustic_field.h), or without skin
};

/// A way to render, with its state from frame to frame, and its results, one number per frame.
struct ModulationWay {
  std::string name;
  ultrasound::FocalPointConfig config;
  ultrasound::FieldSolverOptions options;
  ultrasound::FocalPointRenderer renderer;
  std::vector<ultrasound::Drive> before;

  std::vector<double> points;
  std::vector<double> coverage;           // share of the contact force on skin within 6 dB of the strongest
  std::vector<double> error, weighted;    // shapeError of the rendering
  std::vector<double> pressure, maximum;  // Pa, mean by contact force: as played, and at full drive
  std::vector<double> force;              // N, normal to the skin, of the sound on that skin while it is on
  std::vector<double> vibration;          // dB above what is just felt (FeltForce), if it is known
  std::vector<double> touch;              // N, of a steady touch that feels equally strong, if it is known
  std::vector<double> cost;               // s, of the field solver
};

/// Renders focal points; phases have 32 levels.
ModulationWay pointsWay(const std::string& name, ultrasound::Modulation modulation);
ModulationWay fieldWay(const std::string& name, const ultrasound::FieldSolverOptions& options,
                       const ultrasound::FocalPointConfig& config);

/// Renders a frame, and measures it by the true field of each instant of a period, for fields and points
/// alike.
/// @param pressed samples, frame of the array
/// @param all pressed samples, and the bare ones around them
/// @param skin places at which it is measured; null: it is only rendered
void renderFrame(const Array& array, const Samples& pressed, const Samples& all, const RefinedSkin* skin,
                 ModulationWay& way);

/// Forgets the frames, as at the start of another run, but keeps the results.
void startAnew(ModulationWay& way);

/// Prints a table of the means, one row per way.
void printTable(std::vector<ModulationWay>& ways);

}  // namespace tactile_clay::tools
