#include "hand/hand_cleaner.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "cleaned_hands.h"
#include "hand/hand_check.h"
#include "hand/hand_pose.h"

namespace tactile_clay::hand::hand_cleaner_test {
namespace {

using namespace std::chrono_literals;
using Eigen::Vector3d;
using Nanoseconds = std::chrono::nanoseconds;

TEST(HandCleaner, ARestingHandIsAsItWasSeen) {
  HandCleaner cleaner(CleanConfig{});
  const TrackedHand hand = handAt({0.1, 0.2, 0.3});
  for (int i = 0; i < 20; ++i) {
    const TrackedFrame out = cleaned(cleaner, i * 10ms, {hand});
    ASSERT_EQ(out.hands.size(), 1U);
    for (int joint = 0; joint < joint_count; ++joint) {
      EXPECT_LT((out.hands[0].joints[joint].position - hand.joints[joint].position).norm(), 1e-12);
      EXPECT_LT(out.hands[0].joints[joint].orientation.angularDistance(hand.joints[joint].orientation), 1e-7);
      EXPECT_EQ(out.hands[0].joints[joint].radius, hand.joints[joint].radius);
    }
  }
  EXPECT_EQ(cleaner.counts().dropouts, 0U);
}

TEST(HandCleaner, HoldsFadesAndLetsGo) {
  HandCleaner cleaner(CleanConfig{});
  const TrackedHand hand = handAt(Vector3d::Zero());
  const double radius = hand.joints[index_tip].radius;
  cleaned(cleaner, 1000ms, {hand});
  double last = 1.0;
  for (int ms = 5; ms < 200; ms += 5) {
    const TrackedFrame out = cleaned(cleaner, 1000ms + ms * 1ms, {});
    if (ms >= 80) {
      EXPECT_TRUE(out.hands.empty()) << ms;
      EXPECT_FALSE(cleaner.present());
      continue;
    }
    ASSERT_EQ(out.hands.size(), 1U) << ms;
    EXPECT_EQ(palmOf(out), hand.joints[palm].position);
    const double presence = out.hands[0].confidence;
    EXPECT_NEAR(presence, ms <= 30 ? 1.0 : (80.0 - ms) / 50.0, 1e-9) << ms;
    EXPECT_NEAR(out.hands[0].joints[index_tip].radius / radius, 0.5 + 0.5 * presence, 1e-9);
    EXPECT_LE(presence, last);
    EXPECT_EQ(faultOf(out.hands[0]), "");
    last = presence;
  }
  EXPECT_EQ(cleaner.counts().losses, 1U);
}

// The nodes behind judge the faded hand again, with radii in single precision.
TEST(HandCleaner, AFadingHandKeepsItsRadiiHoweverThinItIs) {
  for (const double thick : {0.36, 0.5, 0.7, 1.0, 1.7}) {
    HandCleaner cleaner(CleanConfig{});
    TrackedHand hand = handAt(Vector3d::Zero());
    for (JointPose& joint : hand.joints) joint.radius *= thick;
    hand.joints[palm].radius *= 0.6;
    ASSERT_EQ(faultOf(hand), "") << thick;
    cleaned(cleaner, 0ms, {hand});
    for (auto t = 10ms; t < 80ms; t += 10ms) {
      TrackedHand fading = cleaned(cleaner, t, {}).hands.at(0);
      for (JointPose& joint : fading.joints) joint.radius = static_cast<float>(joint.radius);
      EXPECT_EQ(faultOf(fading), "") << thick << " at " << t.count();
      EXPECT_LE(fading.joints[index_tip].radius, 1.000001 * hand.joints[index_tip].radius);
    }
  }
}

// hand_tracking asks every 20 ms while the tracker sends nothing.
TEST(HandCleaner, ASlowTrackersHandIsWholeBetweenItsFramesAndGoneInTime) {
  const TrackedHand hand = handAt(Vector3d::Zero());
  for (const int rate : {15, 20, 24, 30, 60, 200}) {
    HandCleaner cleaner(CleanConfig{});
    const auto held = [&](Nanoseconds stamp) {
      TrackedFrame frame = frameOf(stamp, {});
      cleaner.hold(frame);
      return frame;
    };
    Nanoseconds seen = 1s;
    for (int i = 0; i < 3 * rate; ++i) {
      seen = 1s + i * Nanoseconds(1s) / rate;
      const TrackedFrame out = cleaned(cleaner, seen, {hand});
      if (i < 2 * rate) continue;  // it learns
      ASSERT_EQ(out.hands.at(0).confidence, 1.0) << rate;
      for (Nanoseconds t = seen + 20ms; t < seen + Nanoseconds(1s) / rate; t += 20ms)
        ASSERT_EQ(held(t).hands.at(0).confidence, 1.0) << rate << " Hz, " << (t - seen).count();
    }
    for (auto t = 20ms; t <= 200ms; t += 20ms) {
      const TrackedFrame out = held(seen + t);
      EXPECT_EQ(out.hands.empty(), t >= (rate <= 20 ? 100ms : 80ms)) << rate << " Hz, " << t.count();
    }
  }
}

TEST(HandCleaner, AHandThatComesBackInTimeGoesOn) {
  for (const auto pause : {65ms, 90ms})        // while it fades, and just after
    for (const std::uint32_t id : {1U, 2U}) {  // its own or, as trackers do, another
      HandCleaner cleaner(CleanConfig{});
      const TrackedHand hand = handAt(Vector3d::Zero()), back = handAt(Vector3d::Zero(), id);
      const double radius = hand.joints[palm].radius;
      cleaned(cleaner, 1000ms, {hand});
      cleaned(cleaner, 1000ms + pause, {});
      TrackedFrame out = cleaned(cleaner, 1003ms + pause, {back});
      EXPECT_LT(out.hands.at(0).joints[palm].radius, 0.8 * radius);
      out = cleaned(cleaner, 1060ms + pause, {back});
      EXPECT_EQ(out.hands.at(0).joints[palm].radius, radius);
      EXPECT_EQ(cleaner.counts().losses, 0U);
      EXPECT_EQ(cleaner.counts().id_changes, id == 1 ? 0U : 1U);
    }
}

TEST(HandCleaner, AReturningHandOwesNothingToThePast) {
  // Whatever its id, where and how it comes, and whether or not frames came in the meantime.
  for (const std::uint32_t id : {1U, 2U})
    for (const bool frames : {false, true}) {
      HandCleaner cleaner(CleanConfig{});
      for (int i = 0; i < 10; ++i) cleaned(cleaner, i * 10ms, {handAt({0.01 * i, 0.0, 0.0})});
      for (int i = 10; frames && i < 70; ++i) cleaned(cleaner, i * 10ms, {});
      TrackedHand back = handAt({0.1, 0.0, 0.0}, id);
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.0, Vector3d(1.0, 2.0, 0.5).normalized()));
      for (JointPose& joint : back.joints) {
        joint.position = turn * joint.position;
        joint.orientation = turn * joint.orientation;
      }
      const TrackedFrame out = cleaned(cleaner, 700ms, {back});
      for (int joint = 0; joint < joint_count; ++joint) {
        EXPECT_EQ(out.hands.at(0).joints[joint].position, back.joints[joint].position);
        EXPECT_LT(out.hands[0].joints[joint].orientation.angularDistance(back.joints[joint].orientation),
                  1e-7);
        EXPECT_EQ(out.hands[0].joints[joint].radius, back.joints[joint].radius);
      }
      EXPECT_EQ(cleaner.counts().losses, 1U);
      EXPECT_EQ(cleaner.counts().id_changes, 0U);
    }
}

TEST(HandCleaner, PredictsASteadyMotion) {
  CleanConfig config = unfiltered();
  config.prediction = 0.02;
  HandCleaner cleaner(config);
  const Vector3d velocity(0.3, -0.2, 0.1);
  TrackedFrame out;
  for (int i = 0; i <= 50; ++i) out = cleaned(cleaner, i * 10ms, {handAt(i * 0.01 * velocity)});
  const Vector3d expected = handAt(0.52 * velocity).joints[palm].position;
  EXPECT_LT((palmOf(out) - expected).norm(), 1e-6);
}

TEST(HandCleaner, TakesOtherNumbersWhileHandsAreThere) {
  HandCleaner cleaner(CleanConfig{});
  cleaned(cleaner, 0ms, {handAt(Vector3d::Zero())});
  const Vector3d there(0.01, 0.0, 0.0);
  const TrackedFrame smoothed = cleaned(cleaner, 10ms, {handAt(there)});
  cleaner.configure(unfiltered());
  const TrackedHand hand = handAt(there);
  const TrackedFrame passed = cleaned(cleaner, 20ms, {hand});
  EXPECT_GT((palmOf(smoothed) - hand.joints[palm].position).norm(), 1e-3);
  EXPECT_LT((palmOf(passed) - hand.joints[palm].position).norm(), 1e-12);  // the same hand, in its place
  EXPECT_EQ(cleaner.counts().losses, 0U);
  CleanConfig wrong = unfiltered();
  wrong.prediction = 0.03;
  EXPECT_THROW(cleaner.configure(wrong), std::invalid_argument);
  EXPECT_EQ(palmOf(cleaned(cleaner, 30ms, {hand})), palmOf(passed));
}

TEST(HandCleaner, SaysWhichNumberIsWrong) {
  const auto expectFault = [](void (*change)(CleanConfig&), const std::string& words) {
    CleanConfig config;
    change(config);
    try {
      HandCleaner cleaner(config);
      ADD_FAILURE() << words << " is taken";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  expectFault([](CleanConfig& c) { c.prediction = 0.05; },
              "prediction, s: expected a number from 0 to 0.02, got 0.05");
  expectFault([](CleanConfig& c) { c.prediction = nan; }, "prediction");
  expectFault([](CleanConfig& c) { c.position.min_cutoff = 0.0; }, "position min_cutoff");
  expectFault([](CleanConfig& c) { c.orientation.beta = -1.0; }, "orientation beta");
  expectFault([](CleanConfig& c) { c.hold = 0.2; }, "hold");
  expectFault([](CleanConfig& c) { c.gone = 0.03; }, "gone");
}

}  // namespace
}  // namespace tactile_clay::hand::hand_cleaner_test
