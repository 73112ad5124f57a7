#pragma once

#include <string>
#include <vector>

#include "clay/clay.h"
#include "nodes/settings.h"

namespace tactile_clay::nodes {

struct ClayChoice {
  clay::ClayConfig config;
  // The preset; if substeps or iterations differ from it, a text such as "6 x 12".
  std::string quality;
  std::vector<clay::Material> materials;
};

/// Reads and checks quality, solver, substeps, iterations, tolerance, sleeping, and the coefficients of each
/// material.
/// @param config, materials as the scene's file has them
/// @throws std::exception with one line if a parameter is wrong
ClayChoice readClay(Settings& settings, const clay::ClayConfig& config,
                    const std::vector<clay::Material>& materials);

}  // namespace tactile_clay::nodes
