#include "hand/hand_sides.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "hand/hand_check.h"

namespace tactile_clay::hand {

std::size_t keepOneHandASide(std::vector<TrackedHand>& hands) {
  const std::size_t before = hands.size();
  std::vector<TrackedHand> kept;
  for (const TrackedHand& hand : hands) {
    const auto same = std::find_if(kept.begin(), kept.end(),
                                   [&](const TrackedHand& other) { return other.side == hand.side; });
    if (same == kept.end()) {
      kept.push_back(hand);
    } else if (hand.confidence > same->confidence) {
      *same = hand;
    }
  }
  hands = std::move(kept);
  return before - hands.size();
}

std::vector<TrackedHand> leftThenRight(std::vector<TrackedHand> hands) {
  for (const TrackedHand& hand : hands) {
    const std::string fault = faultOfNumbers(hand);
    if (!fault.empty()) throw std::invalid_argument(fault);
  }
  keepOneHandASide(hands);
  std::sort(hands.begin(), hands.end(), [](const auto& a, const auto& b) { return a.side < b.side; });
  return hands;
}

}  // namespace tactile_clay::hand
