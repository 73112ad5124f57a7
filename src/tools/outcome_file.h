#pragma once

#include <optional>
#include <string>

#include "tools/outcome.h"

namespace tactile_clay::tools {

/// A hash of what an outcome depends on, except the budget (FNV-1a, 64 bits). It differs if the particles, a
/// coefficient of a material, the solver's configuration or a sample of the skin differ.
std::string fingerprint(const scene::Scene& scene, const std::vector<HandSample>& samples);

/// Writes an outcome. The file is complete at any time.
/// @param key one line that describes what was played
/// @throws std::runtime_error as files::writeWhole
void saveOutcome(const std::string& file, const std::string& key, const Outcome& outcome);

/// The outcome of `file`, to the bit.
/// @return nothing if there is no such file, or it has another key
/// @throws std::runtime_error if it ends too early
std::optional<Outcome> loadOutcome(const std::string& file, const std::string& key);

}  // namespace tactile_clay::tools
