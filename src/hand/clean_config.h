#pragma once

#include "hand/one_euro.h"
#include "safety/silence_times.h"

namespace tactile_clay::hand {

constexpr double max_prediction = 0.02;  // s; with more, hands overshoot where they turn

struct CleanConfig {
  OneEuroConfig position{2.0, 100.0, 1.0};    // beta in 1/m
  OneEuroConfig orientation{2.0, 10.0, 1.0};  // beta in 1/rad
  /// s; a hand that is not seen stays as it was for `hold`, and has faded out after `gone`
  double hold = silence_times::seconds(silence_times::hand_held);
  double gone = silence_times::seconds(silence_times::hand_gone);
  double same_hand_time = 0.1;       // s after it was last seen, within which it is still the same hand
  double same_hand_distance = 0.05;  // m, of the palm, within which a new id is the same hand
  double blend = 0.1;                // s, over which the step of a changed id is blended
  double artefact_speed = 1.5;       // m/s; an artefact's speed differs by more from its motion
  double artefact_confidence = 0.5;  // an artefact has less
  double prediction = 0.0;           // s ahead, 0 to max_prediction
};

/// @throws std::invalid_argument with one line if a number is out of its range
void validate(const CleanConfig& config);

}  // namespace tactile_clay::hand
