#include "hand/repeated_hands.h"

#include <algorithm>
#include <string>
#include <utility>

namespace tactile_clay::hand {
namespace {

using namespace std::chrono_literals;

// Samples of a hand that are remembered: a tracker may send what its buffers hold in turn.
constexpr std::size_t remembered = 8;
constexpr RepeatedHands::Time stands_still = 50ms;  // longer than a driver takes to send a sample twice

// Two NaN count as the same, too.
bool same(double a, double b) {
  return a == b || (a != a && b != b);
}

bool sameJoints(const TrackedHand& a, const TrackedHand& b) {
  for (int joint = 0; joint < joint_count; ++joint) {
    const JointPose &p = a.joints[joint], &q = b.joints[joint];
    for (int i = 0; i < 3; ++i)
      if (!same(p.position[i], q.position[i])) return false;
    // A quaternion and its negative are the same rotation.
    for (const double sign : {1.0, -1.0}) {
      bool equal = true;
      for (int i = 0; i < 4; ++i)
        equal = equal && same(p.orientation.coeffs()[i], sign * q.orientation.coeffs()[i]);
      if (equal) break;
      if (sign < 0.0) return false;
    }
  }
  return true;
}

}  // namespace

LeftOut RepeatedHands::leaveOutRepeats(std::vector<TrackedHand>& hands, Time now) {
  LeftOut out;
  std::vector<TrackedHand> fresh;
  for (const TrackedHand& hand : hands) {
    std::deque<Sample>& last = last_[hand.side == Side::left ? 0 : 1];
    const auto before = std::find_if(last.begin(), last.end(),
                                     [&](const Sample& sample) { return sameJoints(sample.hand, hand); });
    const bool repeated = before != last.end();
    const Time still = repeated ? now - before->since : Time(0);
    if (!repeated) {
      last.push_back({hand, now});
      if (last.size() > remembered) last.pop_front();
    }
    if (!repeated || still < patience_) {
      fresh.push_back(hand);
      continue;
    }
    ++out.hands;
    if (still >= stands_still)
      out.lines.push_back(
          (hand.side == Side::left ? "left hand " : "right hand ") + std::to_string(hand.id) +
          " left out: the tracker is frozen, all of its joints are the same for " +
          std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(still).count()) +
          " ms, expected another sample with each frame");
  }
  hands = std::move(fresh);
  return out;
}

}  // namespace tactile_clay::hand
