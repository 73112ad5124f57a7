// Cleaning does not make a hand worse: the cleaned palm is never faster than 1.2 times the tracker's highest
// speed, and is off the tracker's palm by no more than the lag of the filter and the noise of the tracker.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "hand/hand_check.h"
#include "hand/hand_cleaner.h"
#include "hand/hand_pose.h"
#include "hand/hand_sides.h"
#include "hand/one_euro.h"
#include "support/hand_recording.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Vector3d;
using Nanoseconds = std::chrono::nanoseconds;

constexpr double max_faster = 1.2;

struct Sample {
  double t;  // s
  Vector3d palm;
};
using Path = std::vector<Sample>;

double fastest(const Path& path) {
  double speed = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i)
    speed = std::max(speed, (path[i].palm - path[i - 1].palm).norm() / (path[i].t - path[i - 1].t));
  return speed;
}

double secondsOf(Nanoseconds time) {
  return 1e-9 * static_cast<double>(time.count());
}

Path pathOf(const std::vector<TrackedFrame>& frames, Side side) {
  Path path;
  for (const TrackedFrame& frame : frames)
    for (const TrackedHand& hand : frame.hands)
      if (hand.side == side) path.push_back({secondsOf(frame.stamp), hand.joints[palm].position});
  return path;
}

std::vector<TrackedFrame> cleaned(std::vector<TrackedFrame> frames) {
  HandCleaner cleaner(CleanConfig{});
  for (TrackedFrame& frame : frames) cleaner.clean(frame);
  return frames;
}

// How far the filter alone lags behind this path, m.
double lagOfTheFilter(const Path& path) {
  OneEuro<3> filter;
  filter.reset(path.front().palm);
  double lag = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i)
    lag = std::max(
        lag, (filter.filter(path[i].palm, path[i].t - path[i - 1].t, CleanConfig().position) - path[i].palm)
                 .norm());
  return lag;
}

double farthest(const Path& raw, const Path& clean) {
  double distance = 0.0;
  for (const Sample& c : clean)
    for (const Sample& r : raw)
      if (c.t == r.t) distance = std::max(distance, (c.palm - r.palm).norm());
  return distance;
}

/// A stroke to and fro: its place, 0 to 1, at time t.
struct Profile {
  const char* name;
  std::function<double(double)> share;  // of u = 0 to 1
};
const std::vector<Profile> profiles = {
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

Stroke randomStroke(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto between = [&](double low, double high) { return low + (high - low) * uniform(random); };
  const double rate = between(30.0, 120.0), length = between(0.05, 0.5), duration = between(0.2, 0.8);
  const double amplitude = between(0.0, 3e-4);
  const Profile& profile = profiles[random() % profiles.size()];
  const int kind = static_cast<int>(random() % 4);  // of confidence: constant, falls, flickers, any
  const double base = uniform(random);
  Vector3d direction(uniform(random) - 0.5, uniform(random) - 0.5, uniform(random) - 0.5);
  direction.normalize();
  Stroke stroke;
  stroke.noise = std::sqrt(3.0) * amplitude;
  for (int k = 0; k < static_cast<int>((2.0 * duration + 1.0) * rate); ++k) {
    const double t = k / rate;
    const double there = profile.share(std::clamp((t - 0.3) / duration, 0.0, 1.0));
    const double back = profile.share(std::clamp((t - 0.6 - duration) / duration, 0.0, 1.0));
    HandPose pose;
    pose.wrist.translation() = length * (there - back) * direction;
    for (int i = 0; i < 3; ++i) pose.wrist.translation()[i] += between(-amplitude, amplitude);
    TrackedHand hand = forwardKinematics(pose);
    hand.confidence = kind == 0   ? base
                      : kind == 1 ? std::max(0.0, 1.0 - t)
                      : kind == 2 ? (k % 3 == 0 ? 0.9 : 0.1)
                                  : uniform(random);
    TrackedFrame frame;
    frame.stamp = Nanoseconds(static_cast<std::int64_t>(1e9 * (1.0 + t)));
    frame.hands = {hand};
    stroke.frames.push_back(frame);
  }
  stroke.words = std::string(profile.name) + ", " + std::to_string(rate) + " Hz, " + std::to_string(length) +
                 " m in " + std::to_string(duration) + " s, confidence of kind " + std::to_string(kind);
  return stroke;
}

TEST(CleanSpeed, AStrokeOfAnyConfidenceStaysAsItIs) {
  std::mt19937 random(31);
  double worst_speed = 0.0, worst_lag = 0.0, worst_left = 0.0;
  for (int i = 0; i < 400; ++i) {
    const Stroke stroke = randomStroke(random);
    const std::vector<TrackedFrame> out = cleaned(stroke.frames);
    const Path raw = pathOf(stroke.frames, Side::right), clean = pathOf(out, Side::right);
    const double ratio = fastest(clean) / fastest(raw), left = farthest(raw, clean),
                 lag = lagOfTheFilter(raw);
    worst_speed = std::max(worst_speed, ratio);
    worst_left = std::max(worst_left, left);
    worst_lag = std::max(worst_lag, lag);
    EXPECT_LE(ratio, max_faster) << i << ": " << stroke.words;
    // A sample was left out at the sharp start of a stroke, and the hand caught up.
    const double held = 2.0 * fastest(raw) / 30.0;
    EXPECT_LE(left, lag + stroke.noise + (left > lag + 1e-6 ? held : 0.0)) << i << ": " << stroke.words;
    EXPECT_GE(clean.size(), 0.95 * raw.size()) << i << ": " << stroke.words;
  }
  std::printf(
      "cleaned strokes: at most %.2f times as fast, %.1f mm from the tracker's, lag of the filter %.1f mm\n",
      worst_speed, 1e3 * worst_left, 1e3 * worst_lag);
}

TEST(CleanSpeed, WhatIsMissedInAStrokeIsCaughtUpWithoutALeap) {
  std::mt19937 random(32);
  for (int i = 0; i < 200; ++i) {
    Stroke stroke = randomStroke(random);
    // 10 to 30 ms without a hand, now and then: unseen for 0.1 s, it would be another hand.
    double from = 1.1, until = 0.0;
    for (TrackedFrame& frame : stroke.frames) {
      const double t = secondsOf(frame.stamp);
      if (t > from) {
        until = from + 0.01 + 0.02 * std::uniform_real_distribution<double>(0.0, 1.0)(random);
        from = until + 0.1;
      }
      if (t < until) frame.hands.clear();
    }
    const Path raw = pathOf(stroke.frames, Side::right), clean = pathOf(cleaned(stroke.frames), Side::right);
    EXPECT_LE(fastest(clean), max_faster * fastest(raw)) << i << ": " << stroke.words;
  }
}

// A tracker with low confidence sees the hand elsewhere for some samples: the hand is not moved there.
TEST(CleanSpeed, ALeapOfAnUnsureHandIsStillLeftOut) {
  std::mt19937 random(33);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int i = 0; i < 200; ++i) {
    Stroke stroke = randomStroke(random);
    const double leap = 0.15 + 0.15 * uniform(random);
    const double rate = 1.0 / (secondsOf(stroke.frames[1].stamp) - secondsOf(stroke.frames[0].stamp));
    const std::size_t at = stroke.frames.size() / 3 + random() % (stroke.frames.size() / 3);
    const std::size_t samples =
        1 + random() % std::max<std::size_t>(1, static_cast<std::size_t>(0.04 * rate));
    for (TrackedFrame& frame : stroke.frames) frame.hands[0].confidence = 0.3;
    std::vector<TrackedFrame> frames = stroke.frames;
    for (std::size_t k = at; k < at + samples; ++k)
      for (JointPose& joint : frames[k].hands[0].joints) joint.position.z() += leap;
    const std::vector<TrackedFrame> out = cleaned(frames);
    for (std::size_t k = at; k < at + samples; ++k)
      for (const TrackedHand& hand : out[k].hands)
        EXPECT_GT((hand.joints[palm].position - frames[k].hands[0].joints[palm].position).norm(), 0.5 * leap)
            << i << ": " << stroke.words;
    const Path raw = pathOf(stroke.frames, Side::right), clean = pathOf(out, Side::right);
    EXPECT_LE(fastest(clean), max_faster * fastest(raw))
        << i << ": " << stroke.words;  // of the hand, not of the leap
  }
}

TEST(CleanSpeed, NoRecordingGetsFaster) {
  int found = 0;
  for (const char* name : hand_recordings) {
    auto frames = recordedFrames(name);
    if (!frames) continue;
    ++found;
    for (TrackedFrame& frame : *frames) {
      leaveOutBadHands(frame.hands);
      keepOneHandASide(frame.hands);
    }
    for (const double confidence : {-1.0, 0.2}) {  // its own; one that is not sure
      for (TrackedFrame& frame : *frames)
        for (TrackedHand& hand : frame.hands)
          if (confidence >= 0.0) hand.confidence = confidence;
      const std::vector<TrackedFrame> out = cleaned(*frames);
      for (const Side side : {Side::left, Side::right}) {
        const Path raw = pathOf(*frames, side), clean = pathOf(out, side);
        if (raw.size() < 2) continue;
        const double ratio = fastest(clean) / fastest(raw), left = farthest(raw, clean);
        std::printf("%-28s %s: raw %.2f m/s, cleaned %.2f m/s, ", name,
                    side == Side::left ? "left " : "right", fastest(raw), fastest(clean));
        std::printf("at most %.1f mm away (filter alone %.1f mm), %zu of %zu\n", 1e3 * left,
                    1e3 * lagOfTheFilter(raw), clean.size(), raw.size());
        EXPECT_LE(ratio, max_faster) << name;
        EXPECT_GE(clean.size(), 0.9 * raw.size()) << name;
      }
    }
  }
  if (found == 0) GTEST_SKIP() << "no recordings";
}

}  // namespace
}  // namespace tactile_clay::hand
