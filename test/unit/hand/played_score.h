#pragma once

#include <algorithm>

#include "hand/kinematic_hand.h"
#include "hand/score.h"

/// Scores, as the hands and the skin that they give.
namespace tactile_clay::hand::played_score {

constexpr double frame_time = 1.0 / 50.0;  // s

/// Skin at every 20 ms of a score, with its time.
template <typename Visitor>
void play(const Score& score, Visitor&& visit, double spacing = 8e-3) {
  KinematicHands hands(spacing);
  for (int i = 0; i * frame_time <= score.duration(); ++i) {
    const TrackedFrame frame = score.sample(i * frame_time);
    visit(i * frame_time, frame, hands.update(frame.hands, frame.stamp));
  }
}

/// Lowest skin: a capsule's lowest point is that of one of its end spheres.
inline double lowest(const TrackedFrame& frame) {
  double z = 1.0;
  for (const TrackedHand& hand : frame.hands)
    for (int joint = 0; joint < joint_count; ++joint)
      if (joint != palm) z = std::min(z, hand.joints[joint].position.z() - hand.joints[joint].radius);
  return z;
}

}  // namespace tactile_clay::hand::played_score
