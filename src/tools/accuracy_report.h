#pragma once

#include <cmath>
#include <cstddef>
#include <ostream>
#include <string>
#include <vector>

#include "clay/clay.h"
#include "tools/outcome.h"

namespace tactile_clay::tools {

/// The inverse of clay::methodNamed.
std::string nameOf(clay::Method method);

/// What was played.
struct Played {
  std::string scene, hands;                          // as given to the program
  double spacing = 0.0;                              // m
  std::size_t particles = 0;                         // of the scene
  double duration = 0.0;                             // s
  std::string material = {};                         // of all bodies; empty: the scene's
  std::string model = "kinematic";                   // of the hand; or soft
  bool tells_skin = false, tells_rendering = false;  // whether the table has these columns
};

/// A budget, what it made of what was played, and how far that is from the reference.
struct Row {
  std::string role;  // "setting", or which of the references it is
  clay::Budget budget;
  Outcome outcome;
  Errors errors;
  double skin = 0.0;                    // m, between samples of the hands' skin
  std::string rendering = "none";       // nameOf(Rendering)
  RenderedPressure rendered{NAN, NAN};  // by it
};

/// Title and head of a table in markdown, to standard output.
void printHead(const Played& played);
/// A line of that table.
void printRow(const Played& played, const Row& row);

void writeCsvHead(std::ostream& csv);
/// A line of CSV, and flushes it: the other settings may take long.
void writeCsvRow(std::ostream& csv, const Played& played, const Row& row);

/// What the reference is known to.
struct Doubt {
  Errors step;   // how it changes when its step is halved
  Errors aside;  // by how much it changes at most when the clay starts a micrometre elsewhere
};

/// Whether the reference may be called converged: halving its step changed it by no more than a tenth of the
/// smallest error in the table, or by no more than twice what a micrometre does ("within chance"): then the
/// scene itself, not a step, decides. A line of markdown each for displacement, height, and force if there is
/// any.
/// @param errors of the settings
std::string convergence(const Doubt& doubt, const std::vector<Errors>& errors);

}  // namespace tactile_clay::tools
