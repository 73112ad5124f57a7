#include "hand/jump_check.h"

#include <algorithm>
#include <utility>

namespace tactile_clay::hand {
namespace {

constexpr double fastest_palm = 20.0;   // m/s; no hand is faster
constexpr double shortest_jump = 0.05;  // m; over a shorter way the stamps of two samples may be too wrong

}  // namespace

bool palmJumps(const TrackedHand& from, const TrackedHand& to, double dt) {
  const double step = (to.joints[palm].position - from.joints[palm].position).norm();
  return step > shortest_jump && step > fastest_palm * dt;
}

LeftOut JumpCheck::leaveOutJumps(std::vector<TrackedHand>& hands, std::chrono::nanoseconds stamp) {
  const double dt = std::chrono::duration<double>(stamp - stamp_).count();
  const std::vector<TrackedHand> last = std::exchange(last_, hands);
  stamp_ = stamp;
  LeftOut out;
  const auto jumps = [&](const TrackedHand& hand) {
    bool known = false, near = false;
    for (const TrackedHand& before : last) {
      if (before.side != hand.side) continue;
      known = true;
      near = near || !palmJumps(before, hand, dt);
    }
    if (!known || near) return false;
    out.lines.push_back(nameOf(hand) +
                        " left out: joint palm: it jumped, expected at most 20 m/s; a hand that stays " +
                        "there is taken for another one");
    ++out.hands;
    return true;
  };
  hands.erase(std::remove_if(hands.begin(), hands.end(), jumps), hands.end());
  return out;
}

}  // namespace tactile_clay::hand
