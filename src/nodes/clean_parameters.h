#pragma once

#include "hand/hand_cleaner.h"
#include "nodes/settings.h"

namespace tactile_clay::nodes {

/// Settings of the filters.
/// @throws std::runtime_error, std::invalid_argument with one line where one is wrong
hand::CleanConfig cleanConfig(Settings& settings);

}  // namespace tactile_clay::nodes
