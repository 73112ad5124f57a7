#pragma once

#include <string>

#include "hand/scripted_tracker.h"

namespace tactile_clay::scene {

/// Reads a score of scripted hands; config/hands/kneading.yaml explains its keys.
/// @param name of a score of config/hands, or a file (with a slash, or ending with .yaml)
/// @throws std::runtime_error with one line
hand::TrackerScript loadScore(const std::string& name, const std::string& package_folder);

/// Whether this is the name of a score of config/hands, or ends as the file of a score does.
bool isScore(const std::string& name, const std::string& package_folder);

}  // namespace tactile_clay::scene
