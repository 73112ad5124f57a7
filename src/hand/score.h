#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "hand/hand_pose.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// How a hand comes to a keyframe from the one before.
enum class Ease {
  minimum_jerk,  // from rest to rest, s = 10 t^3 - 15 t^4 + 6 t^5 (Flash & Hogan 1985)
  steady         // at constant speed
};

struct Keyframe {
  double time;  // s
  HandPose pose;
  Ease ease = Ease::minimum_jerk;
};

/// How far of the way from one keyframe to the next, 0-1.
/// @param s share of the time between them, 0-1
double eased(Ease ease, double s);

/// A tracker's noise: white, normal, the same at the same time. Bones keep their lengths.
struct TrackerNoise {
  double position = 0.0;  // m, standard deviation of each coordinate of the wrist
  double angle = 0.0;     // rad, of each joint
  std::uint32_t seed = 1;
};

/// Scripted motion of hands in frame `world` (z up): one list of keyframes a hand, each in the order of time.
struct Score {
  std::vector<std::vector<Keyframe>> hands;
  TrackerNoise noise;

  double duration() const;  // s, time of the last keyframe

  /// The hands at time t, s; each rests before its first and after its last keyframe.
  TrackedFrame sample(double t) const;
};

/// One score after the other; between them each hand takes `pause` seconds from where it ends to where it
/// starts again, and a hand that a score does not have rests where it was. Noise is the first one's.
Score inTurn(const std::vector<Score>& scores, double pause = 1.0);

}  // namespace tactile_clay::hand
