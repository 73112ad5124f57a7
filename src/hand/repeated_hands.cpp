#include "hand/repeated_hands.h"

#include <algorithm>
#include <string>
#include <utility>

namespace tactile_clay::hand {
namespace {

using namespace std::chrono_literals;

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
    for (int i = 0; i < 4; ++i)
      if (!same(p.orientation.coeffs()[i], q.orientation.coeffs()[i])) return false;
  }
  return true;
}

}  // namespace

LeftOut RepeatedHands::leaveOutRepeats(std::vector<TrackedHand>& hands, Time now) {
  LeftOut out;
  std::vector<Sample> samples;
  std::vector<TrackedHand> fresh;
  for (const TrackedHand& hand : hands) {
    const auto before = std::find_if(last_.begin(), last_.end(), [&](const Sample& sample) {
      return sample.hand.side == hand.side && sameJoints(sample.hand, hand);
    });
    const bool repeated = before != last_.end();
    samples.push_back({hand, repeated ? before->since : now});
    const Time still = now - samples.back().since;
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
  last_ = std::move(samples);
  hands = std::move(fresh);
  return out;
}

}  // namespace tactile_clay::hand
