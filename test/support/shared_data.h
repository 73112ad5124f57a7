#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace tactile_clay {

/// Where a file of the recorded data is looked for: in the folder TACTILE_CLAY_DATA, or beside the checkout.
/// It may not be there.
inline std::filesystem::path sharedData(const std::string& file) {
  const char* given = std::getenv("TACTILE_CLAY_DATA");
  const std::filesystem::path folder =
      given != nullptr ? std::filesystem::path(given)
                       : std::filesystem::path(TACTILE_CLAY_SOURCE_DIR) / "../shared/data";
  return folder / file;
}

/// The recordings of hands that there may be.
inline constexpr const char* hand_recordings[] = {
    "both_hands_low_confidence", "finger_tap", "grab", "left_or_right", "pinch_and_move", "three_claps"};

/// The same for a recording of hands.
inline std::filesystem::path handRecording(const std::string& name) {
  return sharedData("hands/" + name + ".v6.ndjson.gz");
}

}  // namespace tactile_clay
