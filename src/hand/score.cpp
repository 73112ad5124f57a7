#include "hand/score.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>

namespace tactile_clay::hand {
namespace {

HandPose between(const HandPose& a, const HandPose& b, double s) {
  HandPose pose = a;
  pose.wrist = Eigen::Translation3d((1.0 - s) * a.wrist.translation() + s * b.wrist.translation()) *
               Eigen::Quaterniond(a.wrist.rotation()).slerp(s, Eigen::Quaterniond(b.wrist.rotation()));
  for (int finger = 0; finger < finger_count; ++finger) {
    FingerAngles& angles = pose.fingers[finger];
    for (int i = 0; i < 3; ++i)
      angles.flexion[i] = (1.0 - s) * a.fingers[finger].flexion[i] + s * b.fingers[finger].flexion[i];
    angles.abduction = (1.0 - s) * a.fingers[finger].abduction + s * b.fingers[finger].abduction;
  }
  return pose;
}

HandPose poseAt(const std::vector<Keyframe>& keys, double t) {
  const auto next = std::upper_bound(keys.begin(), keys.end(), t,
                                     [](double time, const Keyframe& key) { return time < key.time; });
  if (next == keys.begin()) return keys.front().pose;
  if (next == keys.end()) return keys.back().pose;
  const Keyframe& last = *std::prev(next);
  return between(last.pose, next->pose, eased(next->ease, (t - last.time) / (next->time - last.time)));
}

void addNoise(const TrackerNoise& noise, double t, HandPose& pose) {
  const auto microseconds = static_cast<std::uint64_t>(std::llround(std::max(0.0, t) * 1e6));
  std::seed_seq seed{noise.seed, static_cast<std::uint32_t>(pose.side),
                     static_cast<std::uint32_t>(microseconds),
                     static_cast<std::uint32_t>(microseconds >> 32U)};
  std::mt19937 random(seed);
  // Box-Muller, because std::normal_distribution differs between libraries.
  const auto normal = [&random] {
    const double u = (static_cast<double>(random()) + 1.0) / 4294967297.0;
    const double v = static_cast<double>(random()) / 4294967296.0;
    return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * M_PI * v);
  };
  for (int axis = 0; axis < 3; ++axis) pose.wrist.translation()[axis] += noise.position * normal();
  for (FingerAngles& finger : pose.fingers) {
    for (double& angle : finger.flexion) angle += noise.angle * normal();
    finger.abduction += noise.angle * normal();
  }
}

}  // namespace

double eased(Ease ease, double s) {
  return ease == Ease::steady ? s : s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
}

double Score::duration() const {
  double last = 0.0;
  for (const auto& keys : hands) last = std::max(last, keys.back().time);
  return last;
}

TrackedFrame Score::sample(double t) const {
  TrackedFrame frame;
  frame.frame_id = "world";
  frame.stamp = std::chrono::nanoseconds(std::llround(t * 1e9));
  for (const auto& keys : hands) {
    HandPose pose = poseAt(keys, t);
    if (noise.position > 0.0 || noise.angle > 0.0) addNoise(noise, t, pose);
    frame.hands.push_back(forwardKinematics(pose));
    frame.hands.back().id = static_cast<std::uint32_t>(pose.side) + 1;
  }
  return frame;
}

Score inTurn(const std::vector<Score>& scores, double pause) {
  Score all;
  double start = 0.0;
  for (const Score& score : scores) {
    for (const auto& keys : score.hands) {
      const Side side = keys.front().pose.side;
      auto mine = std::find_if(all.hands.begin(), all.hands.end(),
                               [&](const auto& other) { return other.front().pose.side == side; });
      if (mine == all.hands.end()) {
        mine = all.hands.emplace(all.hands.end());
      } else if (start - pause > mine->back().time) {
        // This hand rested. It starts to move together with the others.
        const HandPose rest = mine->back().pose;
        mine->push_back({start - pause, rest});
      }
      for (Keyframe key : keys) {
        key.time += start;
        mine->push_back(key);
      }
    }
    start += score.duration() + pause;
  }
  if (!scores.empty()) all.noise = scores.front().noise;
  return all;
}

}  // namespace tactile_clay::hand
