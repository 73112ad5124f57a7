#pragma once

#include <string>
#include <vector>

#include "clay/clay.h"
#include "nodes/settings.h"

namespace tactile_clay::nodes {

struct ClayChoice {
  clay::ClayConfig config;
  std::string quality;  // the preset, or as in "6 x 12" where substeps or iterations are others
  std::vector<clay::Material> materials;
};

/// Reads and checks quality, substeps, iterations, tolerance, sleeping, and of each material what it is made
/// of.
/// @param config, materials of the scene's file
/// @throws std::exception with one line where one is wrong
ClayChoice readClay(Settings& settings, const clay::ClayConfig& config,
                    const std::vector<clay::Material>& materials);

}  // namespace tactile_clay::nodes
