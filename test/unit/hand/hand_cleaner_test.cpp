#include "hand/hand_cleaner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "hand/hand_check.h"
#include "hand/hand_pose.h"
#include "hand/hand_sides.h"
#include "support/hand_recording.h"

namespace tactile_clay::hand {
namespace {

using namespace std::chrono_literals;
using Eigen::Vector3d;
using Nanoseconds = std::chrono::nanoseconds;

TrackedHand handAt(const Vector3d& position, std::uint32_t id = 1, Side side = Side::right,
                   double confidence = 1.0) {
  HandPose pose;
  pose.side = side;
  pose.wrist.translation() = position;
  TrackedHand hand = forwardKinematics(pose);
  hand.id = id;
  hand.confidence = confidence;
  return hand;
}

TrackedFrame frameOf(Nanoseconds stamp, std::vector<TrackedHand> hands) {
  TrackedFrame frame;
  frame.stamp = stamp;
  frame.hands = std::move(hands);
  return frame;
}

TrackedFrame cleaned(HandCleaner& cleaner, Nanoseconds stamp, std::vector<TrackedHand> hands) {
  TrackedFrame frame = frameOf(stamp, std::move(hands));
  cleaner.clean(frame);
  return frame;
}

CleanConfig unfiltered() {
  CleanConfig config;
  config.position.min_cutoff = config.orientation.min_cutoff = std::numeric_limits<double>::infinity();
  return config;
}

const Vector3d& palmOf(const TrackedFrame& frame) {
  return frame.hands.at(0).joints[palm].position;
}

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
      for (int i = 10; frames && i < 30; ++i) cleaned(cleaner, i * 10ms, {});
      TrackedHand back = handAt({0.1, 0.0, 0.0}, id);
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.0, Vector3d(1.0, 2.0, 0.5).normalized()));
      for (JointPose& joint : back.joints) {
        joint.position = turn * joint.position;
        joint.orientation = turn * joint.orientation;
      }
      const TrackedFrame out = cleaned(cleaner, 300ms, {back});
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

TEST(HandCleaner, AChangeOfIdAloneIsNotFelt) {
  HandCleaner plain(CleanConfig{}), changing(CleanConfig{});
  double worst = 0.0;
  for (int i = 0; i < 200; ++i) {
    const Vector3d at(0.2 * std::sin(0.03 * i), 0.1 * std::cos(0.05 * i), 0.0);  // up to 0.8 m/s
    const TrackedFrame expected = cleaned(plain, i * 10ms, {handAt(at)});
    const TrackedFrame out = cleaned(changing, i * 10ms, {handAt(at, 1 + i / 40)});
    ASSERT_EQ(out.hands.size(), 1U);
    EXPECT_EQ(out.hands[0].id, 1U + i / 40);
    worst = std::max(worst, (palmOf(out) - palmOf(expected)).norm());
  }
  EXPECT_EQ(changing.counts().id_changes, 4U);
  EXPECT_EQ(changing.counts().dropouts + changing.counts().losses, 0U);
  // With a blend that ignored the motion it would be some 5 mm.
  EXPECT_LT(worst, 0.001);
}

TEST(HandCleaner, TheStepOfANewIdIsBlended) {
  HandCleaner cleaner(unfiltered());
  for (int i = 0; i < 10; ++i) cleaned(cleaner, i * 10ms, {handAt(Vector3d::Zero(), 1)});
  const Vector3d step(0.03, 0.0, 0.0);
  Vector3d last = handAt(Vector3d::Zero()).joints[palm].position;
  const Vector3d goal = last + step;
  for (int i = 0; i <= 10; ++i) {
    const TrackedFrame out = cleaned(cleaner, 100ms + i * 10ms, {handAt(step, 2)});
    EXPECT_LE((palmOf(out) - last).norm(), 0.0031) << i;
    last = palmOf(out);
  }
  EXPECT_LT((last - goal).norm(), 1e-12);
  EXPECT_EQ(cleaner.counts().id_changes, 1U);
}

TEST(HandCleaner, ANewIdElsewhereIsAnotherHand) {
  HandCleaner cleaner(CleanConfig{});
  for (int i = 0; i < 10; ++i) cleaned(cleaner, i * 10ms, {handAt(Vector3d::Zero(), 1)});
  const TrackedHand other = handAt({0.06, 0.0, 0.0}, 2);
  EXPECT_TRUE(cleaned(cleaner, 100ms, {other}).hands.empty());
  EXPECT_EQ(palmOf(cleaned(cleaner, 110ms, {other})), other.joints[palm].position);
  EXPECT_EQ(cleaner.counts().id_changes, 0U);
  EXPECT_EQ(cleaner.counts().jumps, 1U);
}

TEST(HandCleaner, AnUnsureLeapIsAnArtefactAThrowIsNot) {
  for (const double confidence : {1.0, 0.6, 0.4}) {
    HandCleaner cleaner(unfiltered());
    cleaned(cleaner, 0ms, {handAt(Vector3d::Zero(), 1, Side::right, confidence)});
    const TrackedHand leaped = handAt({0.02, 0.0, 0.0}, 1, Side::right, confidence);  // 2 m/s
    const TrackedFrame out = cleaned(cleaner, 10ms, {leaped});
    const bool artefact = confidence < 0.5;
    EXPECT_EQ(palmOf(out),
              artefact ? handAt(Vector3d::Zero()).joints[palm].position : leaped.joints[palm].position);
    EXPECT_EQ(cleaner.counts().artefacts, artefact ? 1U : 0U);
    // A hand that stays there is accepted there.
    TrackedFrame later;
    for (int i = 2; i < 15; ++i) later = cleaned(cleaner, i * 10ms, {leaped});
    EXPECT_EQ(palmOf(later), leaped.joints[palm].position);
  }
}

TEST(HandCleaner, AJumpOfAMetreIsNotAStroke) {
  HandCleaner cleaner(CleanConfig{});
  for (int i = 0; i < 10; ++i) cleaned(cleaner, i * 10ms, {handAt(Vector3d::Zero())});
  const TrackedHand far = handAt({1.0, 0.0, 0.0});
  EXPECT_TRUE(cleaned(cleaner, 100ms, {far}).hands.empty());
  EXPECT_EQ(palmOf(cleaned(cleaner, 110ms, {far})), far.joints[palm].position);
  EXPECT_EQ(cleaner.counts().jumps, 1U);
  // A hand that jumps to and fro is not accepted anywhere.
  for (int i = 12; i < 30; ++i)
    EXPECT_TRUE(cleaned(cleaner, i * 10ms, {i % 2 == 0 ? handAt(Vector3d::Zero()) : far}).hands.empty()) << i;
}

TEST(HandCleaner, AHandTakenForTheOtherOneIsNotThereTwice) {
  HandCleaner cleaner(CleanConfig{});
  cleaned(cleaner, 0ms, {handAt(Vector3d::Zero(), 5, Side::left)});
  TrackedFrame out = cleaned(cleaner, 10ms, {handAt(Vector3d::Zero(), 5, Side::right)});
  ASSERT_EQ(out.hands.size(), 1U);
  EXPECT_EQ(out.hands[0].side, Side::right);
  EXPECT_EQ(cleaner.counts().side_changes, 1U);
  // Another hand that appears does not end the one that is held.
  HandCleaner two(CleanConfig{});
  cleaned(two, 0ms, {handAt(Vector3d::Zero(), 5, Side::left)});
  out = cleaned(two, 10ms, {handAt({0.0, 0.3, 0.0}, 6, Side::right)});
  ASSERT_EQ(out.hands.size(), 2U);
  EXPECT_EQ(out.hands[0].side, Side::left);
}

// A tracker takes the left hand for a second right one, and names it first: the right one stays where it is.
TEST(HandCleaner, OfTwoHandsOfASideTheOneThatWasThereStays) {
  HandCleaner cleaner(unfiltered());
  const TrackedHand own = handAt(Vector3d::Zero(), 5), other = handAt({0.0, 0.3, 0.0}, 6);
  cleaned(cleaner, 0ms, {own});
  for (int i = 1; i < 20; ++i) {
    const bool first = i % 2 == 0;
    const TrackedFrame out = cleaned(cleaner, i * 10ms, {first ? own : other, first ? other : own});
    ASSERT_EQ(out.hands.size(), 1U);
    EXPECT_EQ(out.hands[0].id, 5U) << i;
    EXPECT_EQ(palmOf(out), own.joints[palm].position) << i;
  }
  // Under a new id it is still the nearest.
  const TrackedFrame out = cleaned(cleaner, 200ms, {other, handAt(Vector3d::Zero(), 7)});
  EXPECT_EQ(out.hands.at(0).id, 7U);
  EXPECT_EQ(cleaner.counts().doubles, 20U);
  EXPECT_EQ(cleaner.counts().jumps, 0U);
  // If there was no hand before, the one with the highest confidence is taken.
  HandCleaner fresh(unfiltered());
  EXPECT_EQ(cleaned(fresh, 0ms, {handAt(Vector3d::Zero(), 1, Side::right, 0.2), handAt({0.3, 0.0, 0.0}, 2)})
                .hands.at(0)
                .id,
            2U);
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
  expectFault([](CleanConfig& c) { c.prediction = 0.05; }, "prediction 0.05, expected 0 to 0.02 s");
  expectFault([](CleanConfig& c) { c.prediction = nan; }, "prediction");
  expectFault([](CleanConfig& c) { c.position.min_cutoff = 0.0; }, "position min_cutoff");
  expectFault([](CleanConfig& c) { c.orientation.beta = -1.0; }, "orientation beta");
  expectFault([](CleanConfig& c) { c.hold = 0.2; }, "hold");
  expectFault([](CleanConfig& c) { c.gone = 0.03; }, "gone");
}

// Real hands. Figures are printed; doc/method/hands.md has them.
struct Recorded {
  std::vector<TrackedFrame> frames;  // sane, one hand a side
};

std::optional<Recorded> recorded(const std::string& name) {
  static std::map<std::string, Recorded> known;
  if (const auto found = known.find(name); found != known.end()) return found->second;
  auto frames = recordedFrames(name);
  if (!frames) return std::nullopt;
  for (TrackedFrame& frame : *frames) {
    auto& hands = frame.hands;
    hands.erase(
        std::remove_if(hands.begin(), hands.end(), [](const auto& hand) { return !faultOf(hand).empty(); }),
        hands.end());
    keepOneHandASide(hands);
  }
  return known[name] = Recorded{*frames};
}

const TrackedHand* handOf(const TrackedFrame& frame, Side side) {
  for (const TrackedHand& hand : frame.hands)
    if (hand.side == side) return &hand;
  return nullptr;
}

/// Root mean square distance, m, of index tip and palm to where the tracker saw them `ahead` s later, over
/// hands that it saw then and now under one id.
double errorAhead(const Recorded& recorded, const CleanConfig& config, double ahead) {
  HandCleaner cleaner(config);
  double sum = 0.0;
  std::size_t count = 0, next = 0;
  for (std::size_t i = 0; i < recorded.frames.size(); ++i) {
    TrackedFrame out = recorded.frames[i];
    cleaner.clean(out);
    const double time = 1e-9 * static_cast<double>(out.stamp.count()) + ahead;
    const auto timeOf = [&](std::size_t k) {
      return 1e-9 * static_cast<double>(recorded.frames[k].stamp.count());
    };
    next = std::max(next, i);
    while (next < recorded.frames.size() && timeOf(next) < time) ++next;
    if (next >= recorded.frames.size()) break;
    const std::size_t before = next > i ? next - 1 : i;
    const double share = next > before ? (time - timeOf(before)) / (timeOf(next) - timeOf(before)) : 0.0;
    for (const TrackedHand& hand : out.hands) {
      const TrackedHand* now = handOf(recorded.frames[i], hand.side);
      const TrackedHand* a = handOf(recorded.frames[before], hand.side);
      const TrackedHand* b = handOf(recorded.frames[next], hand.side);
      if (now == nullptr || a == nullptr || b == nullptr || a->id != hand.id || b->id != hand.id) continue;
      for (const int joint : {static_cast<int>(palm), static_cast<int>(index_tip)}) {
        const Vector3d truth = (1.0 - share) * a->joints[joint].position + share * b->joints[joint].position;
        sum += (hand.joints[joint].position - truth).squaredNorm();
        ++count;
      }
    }
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

TEST(HandCleanerOnRecordings, LagAndPrediction) {
  int found = 0;
  std::printf(
      "rms error of palm and index tip, mm; lag of the filter, and error against the truth 10 and 20 ms "
      "later\n"
      "%-28s %8s %8s | %8s %8s | %8s %8s\n",
      "recording", "lag", "lag 1 Hz", "now 10", "pred 10", "now 20", "pred 20");
  for (const char* name : hand_recordings) {
    const auto hands = recorded(name);
    if (!hands) continue;
    ++found;
    const auto error = [&](double ahead, double prediction) {
      CleanConfig config;
      config.prediction = prediction;
      return 1e3 * errorAhead(*hands, config, ahead);
    };
    CleanConfig slow;
    slow.position = {1.0, 0.0, 1.0};
    const double lag = error(0.0, 0.0), slow_lag = 1e3 * errorAhead(*hands, slow, 0.0);
    const double now10 = error(0.01, 0.0), predicted10 = error(0.01, 0.01);
    const double now20 = error(0.02, 0.0), predicted20 = error(0.02, 0.02);
    std::printf("%-28s %8.3f %8.3f | %8.3f %8.3f | %8.3f %8.3f\n", name, lag, slow_lag, now10, predicted10,
                now20, predicted20);
    EXPECT_LE(lag, 2.0) << name;  // 1.95 mm at three_claps, the fastest
    EXPECT_LE(predicted10, now10) << name;
    EXPECT_LE(predicted20, now20) << name;
  }
  if (found == 0) GTEST_SKIP() << "no recordings";
}

TEST(HandCleanerOnRecordings, EveryCleanHandIsSane) {
  int found = 0;
  for (const char* name : hand_recordings) {
    const auto hands = recorded(name);
    if (!hands) continue;
    ++found;
    HandCleaner cleaner(CleanConfig{});
    for (TrackedFrame frame : hands->frames) {
      cleaner.clean(frame);
      for (const TrackedHand& hand : frame.hands) ASSERT_EQ(faultOf(hand), "") << name;
    }
    const CleanCounts& n = cleaner.counts();
    std::printf(
        "%-28s %4zu frames: dropouts %lu, losses %lu, id changes %lu, side changes %lu, artefacts %lu, jumps "
        "%lu\n",
        name, hands->frames.size(), n.dropouts, n.losses, n.id_changes, n.side_changes, n.artefacts, n.jumps);
  }
  if (found == 0) GTEST_SKIP() << "no recordings";
}

}  // namespace
}  // namespace tactile_clay::hand
