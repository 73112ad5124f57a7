// Cleaning does not make a hand worse: the cleaned palm is never faster than 1.2 times the tracker's highest
// speed, and is off the tracker's palm by no more than the lag of the filter and the noise of the tracker.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "hand/hand_check.h"
#include "hand/hand_cleaner.h"
#include "hand/hand_sides.h"
#include "hand/one_euro.h"
#include "strokes.h"
#include "support/hand_recording.h"

namespace tactile_clay::hand::clean_speed_test {
namespace {

using Eigen::Vector3d;
using Nanoseconds = std::chrono::nanoseconds;

constexpr double max_faster = 1.2;

std::vector<TrackedFrame> cleaned(std::vector<TrackedFrame> frames) {
  HandCleaner cleaner(CleanConfig{});
  for (TrackedFrame& frame : frames) cleaner.clean(frame);
  return frames;
}

// How far the filter alone lags behind this path, m.
double lagOfTheFilter(const Path& path) {
  OneEuro<3> filter;
  filter.reset(path.front().place);
  double lag = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i)
    lag = std::max(
        lag, (filter.filter(path[i].place, path[i].t - path[i - 1].t, CleanConfig().position) - path[i].place)
                 .norm());
  return lag;
}

double farthest(const Path& raw, const Path& clean) {
  double distance = 0.0;
  for (const Sample& c : clean)
    for (const Sample& r : raw)
      if (c.t == r.t) distance = std::max(distance, (c.place - r.place).norm());
  return distance;
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

// A hand that is not seen for `shortest` to `longest` s, now and then.
std::vector<TrackedFrame> withGaps(std::vector<TrackedFrame> frames, double shortest, double longest,
                                   std::mt19937& random) {
  double from = 1.1, until = 0.0;
  for (TrackedFrame& frame : frames) {
    const double t = secondsOf(frame.stamp);
    if (t > from) {
      until = from + std::uniform_real_distribution<double>(shortest, longest)(random);
      from = until + 0.1;
    }
    if (t < until) frame.hands.clear();
  }
  return frames;
}

// Of any length: the hand is held, fades, or is gone when it is seen again.
TEST(CleanSpeed, WhatIsMissedInAStrokeIsCaughtUpWithoutALeapOfAnyJoint) {
  std::mt19937 random(32);
  double worst = 0.0;
  for (int i = 0; i < 400; ++i) {
    const Stroke stroke = randomStroke(random);
    const bool is_long = i % 2 == 1;
    const std::vector<TrackedFrame> frames =
        withGaps(stroke.frames, is_long ? 0.03 : 0.01, is_long ? 0.5 : 0.03, random);
    const std::vector<TrackedFrame> out = cleaned(frames);
    for (int joint = 0; joint < joint_count; ++joint) {
      const double raw = fastest(pathOf(frames, Side::right, joint));
      const double ratio = fastest(pathOf(out, Side::right, joint)) / raw;
      worst = std::max(worst, ratio);
      EXPECT_LE(ratio, max_faster) << i << ", joint " << joint << ": " << stroke.words;
    }
  }
  std::printf("strokes with gaps: a joint is at most %.2f times as fast\n", worst);
}

// Every rate and number of lost frames, with prediction, and with a finger that comes back later than its
// hand.
TEST(CleanSpeed, NoJointLeapsAfterAnyNumberOfLostFrames) {
  double worst = 0.0;
  for (const int rate : {30, 38, 60, 90, 120})
    for (int lost = 1; lost <= rate / 2; lost += lost < 12 ? 1 : 7)
      for (const double prediction : {0.0, 0.01, 0.02})
        for (const int late : {0, 1, 3}) {  // frames for which the index finger is missing afterwards
          std::vector<TrackedFrame> frames;
          CleanConfig config;
          config.prediction = prediction;
          HandCleaner cleaner(config);
          std::vector<TrackedFrame> out;
          for (int k = 0; k < rate; ++k) {
            const double u = std::clamp((k - 0.2 * rate) / (0.6 * rate), 0.0, 1.0);
            const double share = profiles.front().share(u);
            HandPose pose;
            pose.wrist.translation().x() = 0.3 * share;
            for (int finger = 1; finger < finger_count; ++finger)
              pose.fingers[finger].flexion.fill(0.8 * share);
            const int since = k - static_cast<int>(0.4 * rate);  // frames since it was lost
            TrackedFrame frame;
            frame.stamp = Nanoseconds(1'000'000'000LL * (rate + k) / rate);
            if (since < 0 || since >= lost) frame.hands = {forwardKinematics(pose)};
            if (since >= lost && since < lost + late)
              for (int joint = index_metacarpal; joint <= index_tip; ++joint)
                frame.hands[0].missing.set(joint);
            frames.push_back(frame);
            cleaner.clean(frame);
            out.push_back(frame);
          }
          for (int joint = 0; joint < joint_count; ++joint) {
            const double raw = fastest(pathOf(frames, Side::right, joint));
            const double ratio = fastest(pathOf(out, Side::right, joint)) / raw;
            worst = std::max(worst, ratio);
            EXPECT_LE(ratio, max_faster) << rate << " Hz, " << lost << " lost, " << late
                                         << " late, prediction " << prediction << ", joint " << joint;
          }
          EXPECT_FALSE(out.back().hands.empty());
        }
  std::printf("lost frames: a joint is at most %.2f times as fast\n", worst);
}

// A hand that was gone is felt again soon: at once if it is where it was, and else when it could have come.
TEST(CleanSpeed, AHandThatWasGoneIsBackSoon) {
  for (const double speed : {0.0, 0.05, 0.2, 1.0}) {  // m/s, while it is not seen
    HandCleaner cleaner(CleanConfig{});
    double back = 0.0;
    for (int ms = 0; ms < 1000; ms += 10) {
      HandPose pose;
      // It moved at 1 m/s before.
      pose.wrist.translation().x() = 1e-3 * (std::min(ms, 300) + speed * std::clamp(ms - 300, 0, 200));
      TrackedFrame frame;
      frame.stamp = std::chrono::milliseconds(1000 + ms);
      if (ms <= 300 || ms >= 500) frame.hands = {forwardKinematics(pose)};
      cleaner.clean(frame);
      if (ms >= 500 && back == 0.0 && !frame.hands.empty()) back = 1e-3 * (ms - 500);
    }
    // 70 ms after it was lost it was shown for the last time. 1.15 (t - 0.07) = 0.2 at speed 1: t = 0.24 s.
    EXPECT_NEAR(back, speed == 1.0 ? 0.05 : 0.0, 0.011) << speed;
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
        for (int joint = 0; joint < joint_count; ++joint)
          EXPECT_LE(fastest(pathOf(out, side, joint)), max_faster * fastest(pathOf(*frames, side, joint)))
              << name << ", joint " << joint;
        EXPECT_GE(clean.size(), 0.9 * raw.size()) << name;
      }
    }
  }
  if (found == 0) GTEST_SKIP() << "no recordings";
}

}  // namespace
}  // namespace tactile_clay::hand::clean_speed_test
