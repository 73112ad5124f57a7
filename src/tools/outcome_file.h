#pragma once

#include <optional>
#include <string>

#include "tools/outcome.h"

namespace tactile_clay::tools {

/// What an outcome follows from, beside the budget: a number that differs where the particles, a coefficient
/// of a material, the solver's configuration or a sample of the skin does (FNV-1a, 64 bits).
std::string fingerprint(const scene::Scene& scene, const std::vector<HandSample>& samples);

/// Writes an outcome; what is at `file` is whole at any time.
/// @param key one line of what was played
/// @throws std::runtime_error as files::writeWhole
void saveOutcome(const std::string& file, const std::string& key, const Outcome& outcome);

/// The outcome of `file`, to the bit.
/// @return nothing if there is no such file, or it is of another key
/// @throws std::runtime_error if it is broken off
std::optional<Outcome> loadOutcome(const std::string& file, const std::string& key);

}  // namespace tactile_clay::tools
