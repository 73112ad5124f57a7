#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "hand/hand_pose.h"
#include "hand/tracked_hand.h"

/// Random strokes of a hand, and the paths of its joints, for the tests of the cleaner of hands.
namespace tactile_clay::hand {

struct Sample {
  double t;  // s
  Eigen::Vector3d place;
};
using Path = std::vector<Sample>;

/// Highest speed between two samples of a path, m/s.
inline double fastest(const Path& path) {
  double speed = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i)
    speed = std::max(speed, (path[i].place - path[i - 1].place).norm() / (path[i].t - path[i - 1].t));
  return speed;
}

inline double secondsOf(std::chrono::nanoseconds time) {
  return 1e-9 * static_cast<double>(time.count());
}

/// Where a joint was in all frames that have a hand of this side.
inline Path pathOf(const std::vector<TrackedFrame>& frames, Side side, int joint = palm) {
  Path path;
  for (const TrackedFrame& frame : frames)
    for (const TrackedHand& hand : frame.hands)
      if (hand.side == side && !hand.missing[joint])
        path.push_back({secondsOf(frame.stamp), hand.joints[joint].position});
  return path;
}

/// A stroke to and fro: its place, 0 to 1, at time t.
struct Profile {
  const char* name;
  std::function<double(double)> share;  // of u = 0 to 1
};
inline const std::vector<Profile> profiles = {
    {"minimum jerk", [](double u) { return u * u * u * (10.0 + u * (6.0 * u - 15.0)); }},
    {"sine", [](double u) { return 0.5 - 0.5 * std::cos(M_PI * u); }},
    {"constant speed", [](double u) { return u; }},
    {"from rest to full speed", [](double u) { return u * u; }},
    {"from full speed to rest", [](double u) { return u * (2.0 - u); }}};

struct Stroke {
  std::vector<TrackedFrame> frames;
  std::string words;
  double noise;  // m, the tracker's greatest
};

/// A hand goes there and back, and closes and opens at the same time.
inline Stroke randomStroke(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto between = [&](double low, double high) { return low + (high - low) * uniform(random); };
  const double rate = between(30.0, 120.0), length = between(0.05, 0.5), duration = between(0.2, 0.8);
  const double amplitude = between(0.0, 3e-4);
  const Profile& profile = profiles[random() % profiles.size()];
  const int kind = static_cast<int>(random() % 4);  // of confidence: constant, falls, flickers, any
  const double base = uniform(random);
  Eigen::Vector3d direction(uniform(random) - 0.5, uniform(random) - 0.5, uniform(random) - 0.5);
  direction.normalize();
  const double curl = between(0.0, 1.2);  // rad, of each joint of a finger
  Stroke stroke;
  stroke.noise = std::sqrt(3.0) * amplitude;
  for (int k = 0; k < static_cast<int>((2.0 * duration + 1.0) * rate); ++k) {
    const double t = k / rate;
    const double there = profile.share(std::clamp((t - 0.3) / duration, 0.0, 1.0));
    const double back = profile.share(std::clamp((t - 0.6 - duration) / duration, 0.0, 1.0));
    HandPose pose;
    pose.wrist.translation() = length * (there - back) * direction;
    for (int i = 0; i < 3; ++i) pose.wrist.translation()[i] += between(-amplitude, amplitude);
    for (int finger = 1; finger < finger_count; ++finger)
      pose.fingers[finger].flexion.fill(curl * (there - back));
    TrackedHand hand = forwardKinematics(pose);
    hand.confidence = kind == 0   ? base
                      : kind == 1 ? std::max(0.0, 1.0 - t)
                      : kind == 2 ? (k % 3 == 0 ? 0.9 : 0.1)
                                  : uniform(random);
    TrackedFrame frame;
    frame.stamp = std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * (1.0 + t)));
    frame.hands = {hand};
    stroke.frames.push_back(frame);
  }
  stroke.words = std::string(profile.name) + ", " + std::to_string(rate) + " Hz, " + std::to_string(length) +
                 " m in " + std::to_string(duration) + " s, confidence of kind " + std::to_string(kind);
  return stroke;
}

}  // namespace tactile_clay::hand
