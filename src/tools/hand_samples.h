#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "hand/tracked_hand.h"
#include "values/skin.h"

namespace tactile_clay::tools {

/// The skin of all hands at one time.
struct HandSample {
  double duration = 0.0;  // s, since the sample before
  Skin skin;

  // The tracked hands of this skin, from which soft hands are made.
  std::vector<hand::TrackedHand> hands = {};  // in the world
  std::chrono::nanoseconds stamp{0};
};

/// What hands do, sample by sample: scripted hands at 60 Hz, without dropouts; recorded hands as often as
/// they were seen.
/// @param hands none, knead, potter, press, a score of config/hands or its YAML file, or a Leap recording
/// @param duration s, at most that of a recording; 0: all that the hands do, 1.2 s without hands
/// @param spacing of the skin, m
/// @param share the package's share folder, whose config/rig.yaml has the pose of the tracker of a recording
/// @throws std::runtime_error with one line: what, where, what was expected
std::vector<HandSample> handSamples(const std::string& hands, double duration, double spacing,
                                    const std::string& share);

}  // namespace tactile_clay::tools
