#pragma once

#include <map>
#include <string>
#include <vector>

#include "hand/leap_json.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand::leap {

struct Pointables {
  std::map<std::string, std::vector<const Json*>> of_hand;  // by the id of the hand
  std::string fault;  // one line about those that name no hand; empty: there are none
};

/// Reads one hand of a frame, as parseLeapFrame describes it. What cannot be read of a finger makes joints of
/// this finger missing, with the reason in `unread`; the hand goes on without them.
/// @throws std::runtime_error with one line if a field of the hand as a whole cannot be read, or if what is
/// left is no hand
TrackedHand readHand(const Json& hand, const std::string& id, const Pointables& pointables);

}  // namespace tactile_clay::hand::leap
