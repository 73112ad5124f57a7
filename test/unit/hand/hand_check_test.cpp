#include "hand/hand_check.h"
#include "hand/jump_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "hand/anatomy.h"
#include "hand/hand_pose.h"
#include "hand/repeated_hands.h"
#include "support/hand_recording.h"

namespace tactile_clay::hand {
namespace {

using namespace std::chrono_literals;
using Eigen::Vector3d;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

HandPose bentPose(Side side, double scale = 1.05) {
  HandPose pose;
  pose.side = side;
  pose.scale = scale;
  pose.wrist =
      Eigen::Translation3d(0.1, -0.2, 0.3) * Eigen::AngleAxisd(0.7, Vector3d(1.0, -2.0, 0.5).normalized());
  for (FingerAngles& finger : pose.fingers) finger.flexion = {0.3, 0.3, 0.25};
  return pose;
}

TrackedHand bentHand(Side side = Side::right, double scale = 1.05) {
  TrackedHand hand = forwardKinematics(bentPose(side, scale));
  hand.id = 7;
  return hand;
}

bool sameBits(const JointPose& a, const JointPose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs() && a.radius == b.radius;
}

bool contains(const std::string& line, const std::string& part) {
  return line.find(part) != std::string::npos && line.find('\n') == std::string::npos;
}

/// Expects that nothing is wrong, and that nothing is changed.
void expectTaken(const TrackedHand& hand, const std::string& what) {
  TrackedHand judged = hand;
  const HandFaults faults = judge(judged);
  EXPECT_TRUE(faults.usable) << what;
  EXPECT_EQ(faults.lines, std::vector<std::string>()) << what;
  EXPECT_TRUE(judged.missing.none()) << what;
  for (int joint = 0; joint < joint_count; ++joint)
    EXPECT_TRUE(sameBits(judged.joints[joint], hand.joints[joint])) << what << ", joint " << joint;
}

TEST(HandCheck, TakesHandsOfAllSizesInAllPoses) {
  std::mt19937 random(31);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  constexpr double beyond = 15.0 * M_PI / 180.0;  // bent back and crossed farther than the tables' ranges
  for (int i = 0; i < 2000; ++i) {
    HandPose pose;
    pose.side = i % 2 == 0 ? Side::left : Side::right;
    pose.scale = 0.7 + 0.6 * share(random);
    pose.wrist =
        Eigen::Translation3d(share(random), share(random), share(random)) * Eigen::Quaterniond::UnitRandom();
    for (int f = 0; f < finger_count; ++f) {
      const auto within = [&](const Eigen::Vector2d& limit) {
        return limit[0] - beyond + share(random) * (limit[1] - limit[0] + 2.0 * beyond);
      };
      for (int k = 0; k < 3; ++k) pose.fingers[f].flexion[k] = within(finger_limits[f].flexion[k]);
      pose.fingers[f].abduction = within(finger_limits[f].abduction);
    }
    expectTaken(forwardKinematics(pose), "hand " + std::to_string(i));
  }
}

TEST(HandCheck, TakesEveryHandOfTheRecordings) {
  int found = 0;
  for (const char* name : hand_recordings) {
    const auto frames = recordedFrames(name);
    if (!frames) continue;
    ++found;
    for (const TrackedFrame& frame : *frames)
      for (const TrackedHand& hand : frame.hands) {
        expectTaken(hand, name);
        if (HasFailure()) return;
      }
  }
  if (found == 0) GTEST_SKIP() << "no recordings";
}

struct Spoilt {
  const char* how;
  std::function<void(TrackedHand&)> spoil;
  const char* words;  // of the line
};

void scaleBy(TrackedHand& hand, double factor) {
  for (JointPose& joint : hand.joints) {
    joint.position *= factor;
    joint.radius *= factor;
  }
}

void putAll(TrackedHand& hand, const Vector3d& at) {
  for (JointPose& joint : hand.joints) joint.position = at;
}

TEST(HandCheck, WhatIsNoHandIsLeftOut) {
  const std::vector<Spoilt> kinds = {
      {"all at the origin", [](auto& h) { putAll(h, Vector3d::Zero()); }, "its bones are 0 times"},
      {"all at the origin, no radii",
       [](auto& h) {
         putAll(h, Vector3d::Zero());
         for (JointPose& joint : h.joints) joint.radius = 0.0;
       },
       "its bones are 0 times"},
      {"all at one point",
       [](auto& h) {
         putAll(h, {0.1, 0.2, 0.3});
       },
       "its bones are 0 times"},
      {"all at the palm", [](auto& h) { putAll(h, h.joints[palm].position); }, "its bones are 0 times"},
      {"in millimetres", [](auto& h) { scaleBy(h, 1000.0); }, "within 10 m"},
      {"ten times too large", [](auto& h) { scaleBy(h, 10.0); }, "times an adult's, expected 0.4 to 2"},
      {"ten times too small", [](auto& h) { scaleBy(h, 0.1); }, "times an adult's, expected 0.4 to 2"},
      {"the palm far off", [](auto& h) { h.joints[palm].position.x() += 0.3; }, "joint palm: distance"},
      {"the palm at the origin", [](auto& h) { h.joints[palm].position.setZero(); }, "joint palm: distance"},
      {"the wrist far off", [](auto& h) { h.joints[wrist].position.x() += 0.3; }, "joint wrist: distance"},
      {"the palm NaN", [](auto& h) { h.joints[palm].position.x() = nan; }, "joint palm: position"},
      {"the wrist not turned", [](auto& h) { h.joints[wrist].orientation.coeffs().setZero(); },
       "joint wrist: orientation"},
      {"palm and wrist exchanged", [](auto& h) { std::swap(h.joints[palm], h.joints[wrist]); },
       "behind the wrist"},
      {"from tip to wrist", [](auto& h) { std::reverse(h.joints.begin(), h.joints.end()); }, "expected"},
      {"fingers before the palm",
       [](auto& h) { std::rotate(h.joints.begin(), h.joints.begin() + 2, h.joints.end()); }, "expected"},
      {"little finger first",
       [](auto& h) {
         for (int i = 0; i < 5; ++i) {
           std::swap(h.joints[index_metacarpal + i], h.joints[little_metacarpal + i]);
           std::swap(h.joints[middle_metacarpal + i], h.joints[ring_metacarpal + i]);
         }
       },
       "expected"},
      {"index and ring finger exchanged",
       [](auto& h) {
         for (int i = 0; i < 5; ++i) std::swap(h.joints[index_metacarpal + i], h.joints[ring_metacarpal + i]);
       },
       "in the order index, middle, ring, little"},
      {"three fingers lost",
       [](auto& h) {
         for (int joint = middle_metacarpal; joint < joint_count; ++joint) h.joints[joint].position.setZero();
       },
       "its bones are 0 times"},
      {"sent as the other hand", [](auto& h) { h.side = h.side == Side::left ? Side::right : Side::left; },
       "or mirrored?"},
      {"seen in a mirror",
       [](auto& h) {
         for (JointPose& joint : h.joints)
           joint = {mirrored(joint.position), mirrored(joint.orientation), joint.radius};
       },
       "or mirrored?"},
      {"a fist in a mirror, turned as if it was none",
       [](auto& h) {
         HandPose pose = bentPose(h.side);
         for (int f = 1; f < finger_count; ++f) pose.fingers[f].flexion = {1.2, 0.6, 0.3};
         pose.wrist.setIdentity();
         h = forwardKinematics(pose);
         for (JointPose& joint : h.joints) joint.position.y() *= -1.0;
       },
       "or mirrored?"},
      {"of no side", [](auto& h) { h.side = static_cast<Side>(7); },
       "side 7, expected 0 (left) or 1 (right)"},
      {"of no confidence", [](auto& h) { h.confidence = nan; }, "confidence"}};
  for (const Side side : {Side::left, Side::right})
    for (const Spoilt& kind : kinds) {
      std::vector<TrackedHand> hands = {bentHand(side), bentHand(side)};
      kind.spoil(hands[0]);
      const std::string fault = faultOf(hands[0]);
      EXPECT_TRUE(contains(fault, kind.words)) << kind.how << ": " << fault;
      EXPECT_TRUE(contains(fault, "left out")) << fault;
      const LeftOut out = leaveOutBadHands(hands);
      EXPECT_EQ(out.hands, 1U) << kind.how;
      EXPECT_EQ(out.lines.size(), 1U) << kind.how;
      ASSERT_EQ(hands.size(), 1U) << kind.how;
      EXPECT_EQ(faultOf(hands[0]), "");
    }
}

// The models of the hand need only numbers that can be posed; whether it is a plausible hand is judged
// separately.
TEST(HandCheck, FaultsOfNumbersAreThoseThatNoModelCanPose) {
  const TrackedHand hand = bentHand();
  EXPECT_EQ(faultOfNumbers(hand), "");
  TrackedHand tiny = hand;
  for (JointPose& joint : tiny.joints) joint.position *= 1e-3;
  EXPECT_EQ(faultOfNumbers(tiny), "");
  EXPECT_NE(faultOf(tiny), "");
  const auto spoilt = [&](const std::function<void(TrackedHand&)>& spoil) {
    TrackedHand bad = hand;
    spoil(bad);
    return faultOfNumbers(bad);
  };
  EXPECT_TRUE(
      contains(spoilt([](auto& h) { h.joints[index_tip].position.z() = nan; }), "joint index_tip: position"));
  EXPECT_TRUE(
      contains(spoilt([](auto& h) { h.joints[wrist].orientation.coeffs().setZero(); }), "orientation"));
  for (const double radius : {nan, infinity, -0.01})
    EXPECT_TRUE(
        contains(spoilt([&](auto& h) { h.joints[thumb_tip].radius = radius; }), "joint thumb_tip: radius"));
  EXPECT_TRUE(contains(spoilt([](auto& h) { h.confidence = nan; }), "hand 7: confidence"));
  EXPECT_TRUE(contains(spoilt([](auto& h) { h.side = static_cast<Side>(7); }), "side 7"));
}

// Each way to spoil one finger, from its knuckle on or completely.
struct SpoiltFinger {
  const char* how;
  bool all;  // palm part too
  std::function<void(TrackedHand&, const FingerJoints&)> spoil;
};

TEST(HandCheck, AFingerThatIsNotThereIsMissing) {
  const auto each = [](TrackedHand& h, const FingerJoints& f, const std::function<void(JointPose&)>& change) {
    for (int i = 0; i < f.count; ++i) change(h.joints[f[i]]);
  };
  const std::vector<SpoiltFinger> kinds = {
      {"at the origin", true, [&](auto& h, auto& f) { each(h, f, [](auto& j) { j.position.setZero(); }); }},
      {"zeros, without radii", true,
       [&](auto& h, auto& f) {
         each(h, f, [](auto& j) { j = {Vector3d::Zero(), Eigen::Quaterniond::Identity(), 0.0}; });
       }},
      {"at one far point", true,
       [&](auto& h, auto& f) { each(h, f, [](auto& j) { j.position = Vector3d(0.4, 0.4, 0.0); }); }},
      {"frozen beside the hand", true,
       [&](auto& h, auto& f) { each(h, f, [](auto& j) { j.position += Vector3d(0.0, 0.07, 0.07); }); }},
      {"all of it NaN", true,
       [&](auto& h, auto& f) { each(h, f, [](auto& j) { j.position.setConstant(nan); }); }},
      {"collapsed on its knuckle", false,
       [](auto& h, auto& f) {
         for (int i = f.count - 3; i < f.count; ++i)
           h.joints[f[i]].position = h.joints[f[f.count - 4]].position;
       }},
      {"its tip far off", false,
       [](auto& h, auto& f) {
         const Vector3d bone = h.joints[f.tip()].position - h.joints[f[f.count - 2]].position;
         h.joints[f.tip()].position += 0.07 * bone.normalized();
       }},
      {"its tip at the origin", false, [](auto& h, auto& f) { h.joints[f.tip()].position.setZero(); }},
      {"its tip infinite", false, [](auto& h, auto& f) { h.joints[f.tip()].position.y() = infinity; }},
      {"two joints in one place", false,
       [](auto& h, auto& f) { h.joints[f[f.count - 2]].position = h.joints[f[f.count - 3]].position; }},
      {"its tip turned by NaN", false, [](auto& h, auto& f) { h.joints[f.tip()].orientation.w() = nan; }},
      {"its tip not turned", false,
       [](auto& h, auto& f) { h.joints[f.tip()].orientation.coeffs().setZero(); }}};
  static const std::array<const char*, finger_count> names = {"thumb", "index", "middle", "ring", "little"};
  for (const double scale : {0.7, 1.3})
    for (const SpoiltFinger& kind : kinds)
      for (int f = 0; f < finger_count; ++f) {
        const TrackedHand good = bentHand(Side::left, scale);
        TrackedHand hand = good;
        kind.spoil(hand, fingers[f]);
        const HandFaults faults = judge(hand);
        const std::string which = std::string(kind.how) + ", " + names[f];
        ASSERT_TRUE(faults.usable) << which << ": " << faults.lines.front();
        EXPECT_EQ(faults.fingers, 1) << which;
        ASSERT_EQ(faults.lines.size(), 1U) << which;
        EXPECT_TRUE(contains(faults.lines[0], "left hand 7, " + std::string(names[f]))) << faults.lines[0];
        EXPECT_TRUE(contains(faults.lines[0], "left out: joint " + std::string(names[f]) + "_"))
            << faults.lines[0];
        const int first = kind.all || f == 0 ? 0 : 2;
        for (int joint = 0; joint < joint_count; ++joint) {
          const bool lost = joint >= fingers[f].first + first && joint <= fingers[f].tip();
          EXPECT_EQ(hand.missing[joint], lost) << which << ", joint " << joint;
          EXPECT_TRUE(lost || sameBits(hand.joints[joint], good.joints[joint]))
              << which << ", joint " << joint;
          EXPECT_TRUE(hand.joints[joint].position.allFinite()) << which;
        }
        EXPECT_EQ(faultOf(hand), "") << which;  // it is told once
      }
}

TEST(HandCheck, RadiiThatNoHandHasAreThoseOfTheTable) {
  const TrackedHand good = bentHand(Side::left, 0.9);
  for (const double wrong : {0.0, -0.01, nan, infinity, 0.09, 8.0}) {
    for (const bool all : {false, true}) {
      TrackedHand hand = good;
      for (int joint = 0; joint < joint_count; ++joint)
        if (all || joint == ring_tip) hand.joints[joint].radius = wrong;
      const HandFaults faults = judge(hand);
      ASSERT_TRUE(faults.usable) << wrong;
      ASSERT_EQ(faults.lines.size(), 1U) << wrong;
      EXPECT_TRUE(contains(faults.lines[0], all ? "joint palm: radius" : "joint ring_tip: radius"))
          << faults.lines[0];
      EXPECT_TRUE(hand.missing.none()) << wrong;
      for (int joint = 0; joint < joint_count; ++joint)
        EXPECT_NEAR(hand.joints[joint].radius, 0.9 * joint_anatomy[joint].radius, 1e-12) << wrong;
    }
  }
  // Trackers have other radii, and a hand that fades out has half of them.
  for (const double factor : {0.4, 1.6}) {
    TrackedHand hand = good;
    for (JointPose& joint : hand.joints) joint.radius *= factor;
    expectTaken(hand, "radii");
  }
}

TrackedHand at(const Vector3d& position, Side side = Side::right) {
  TrackedHand hand = bentHand(side);
  for (JointPose& joint : hand.joints) joint.position += position;
  return hand;
}

TEST(JumpCheck, AHandIsNotInTwoPlacesInTurn) {
  JumpCheck check;
  std::vector<std::size_t> left;
  for (int i = 0; i < 12; ++i) {
    // It jumps to and fro; its other hand stays. From the ninth sample on it is somewhere else.
    std::vector<TrackedHand> hands = {at(i < 8 && i % 2 == 1 ? Vector3d(0.4, 0.0, 0.0) : Vector3d::Zero()),
                                      at({0.0, 0.3, 0.0}, Side::left)};
    const LeftOut out = check.leaveOutJumps(hands, i * 10ms);
    left.push_back(out.hands);
    ASSERT_EQ(hands.size(), 2 - out.hands);
    EXPECT_EQ(hands.back().side, Side::left);
    for (const std::string& line : out.lines)
      EXPECT_TRUE(contains(line, "right hand 7 left out: joint palm: it jumped"));
  }
  EXPECT_EQ(left, std::vector<std::size_t>({0, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0}));
}

TEST(JumpCheck, AThrowIsNoJump) {
  JumpCheck check;
  for (int i = 0; i < 20; ++i) {  // 12 m/s, and a slow tracker's steps
    std::vector<TrackedHand> hands = {at({0.12 * i, 0.0, 0.0})};
    EXPECT_EQ(check.leaveOutJumps(hands, i * 10ms).hands, 0U);
  }
  JumpCheck slow;
  for (int i = 0; i < 20; ++i) {
    std::vector<TrackedHand> hands = {at({0.3 * i, 0.0, 0.0})};
    EXPECT_EQ(slow.leaveOutJumps(hands, i * 66ms).hands, 0U);
  }
}

TEST(RepeatedHands, WhatHasTheSameBitsWasNotSeenAgain) {
  RepeatedHands check(0ns);
  TrackedHand still = at(Vector3d::Zero());
  for (int i = 0; i < 30; ++i) {
    TrackedHand moving = at({0.0, 0.3 + 1e-9 * i, 0.0}, Side::left);
    still.id = 100 + i;  // what the tracker says beside the joints is no sign of life
    still.confidence = 0.01 * i;
    std::vector<TrackedHand> hands = {still, moving};
    const LeftOut out = check.leaveOutRepeats(hands, i * 10ms);
    EXPECT_EQ(out.hands, i == 0 ? 0U : 1U) << i;
    EXPECT_EQ(hands.size(), i == 0 ? 2U : 1U) << i;
    EXPECT_EQ(hands.back().side, Side::left);
    EXPECT_EQ(out.lines.size(), i < 5 ? 0U : 1U) << i;  // a driver may send a sample twice
    if (i != 20) continue;
    EXPECT_TRUE(contains(out.lines.at(0), "is frozen, all of its joints are the same for 200 ms"))
        << out.lines[0];
  }
  std::vector<TrackedHand> hands = {at({1e-12, 0.0, 0.0})};
  EXPECT_EQ(check.leaveOutRepeats(hands, 300ms).hands, 0U);
}

TEST(RepeatedHands, AreWaitedForWhereNobodyBridgesThem) {
  RepeatedHands check(60ms);
  for (int i = 0; i < 60; ++i) {  // each sample twice, then one for ever
    std::vector<TrackedHand> hands = {at({0.001 * std::min(i / 2, 20), 0.0, 0.0})};
    const LeftOut out = check.leaveOutRepeats(hands, i * 10ms);
    EXPECT_EQ(out.hands, i < 46 ? 0U : 1U) << i;
  }
}

}  // namespace
}  // namespace tactile_clay::hand
