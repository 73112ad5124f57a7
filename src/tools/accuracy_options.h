#pragma once

#include <string>
#include <vector>

#include "clay/clay.h"
#include "tools/rendered_pressure.h"

namespace tactile_clay::tools {

/// What speed_accuracy plays, and where what comes of it goes.
struct AccuracyOptions {
  std::string scene, hands, csv, share, outcomes;
  int shard = 1, shards = 1;
  bool merge = false;
  double duration = 0.0;  // s; 0: the hand's
  int threads = 0;
  std::vector<double> spacings;                // m; 0: the scene's
  std::vector<std::string> materials, models;  // of all bodies, and of hands; "": the scene's
  std::vector<double> skins;                   // m; 0: the spacing
  std::vector<Rendering> renderings;
  std::vector<clay::Budget> settings;
  clay::Budget reference;
};

/// Out of the arguments of the program, as its usage has them.
/// @throws std::runtime_error with one line: what was found, what was expected
AccuracyOptions accuracyOptions(int argc, char** argv);

}  // namespace tactile_clay::tools
