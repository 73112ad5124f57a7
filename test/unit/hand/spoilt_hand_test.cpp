#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "bent_hand.h"
#include "hand/anatomy.h"
#include "hand/hand_check.h"
#include "hand/hand_pose.h"

namespace tactile_clay::hand::spoilt_hand_test {
namespace {

using Eigen::Vector3d;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

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

/// Hands of no size, and hands whose joints are not where a hand has them.
std::vector<Spoilt> misplacedHands() {
  return {
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
      {"three fingers lost",
       [](auto& h) {
         for (int joint = middle_metacarpal; joint < joint_count; ++joint) h.joints[joint].position.setZero();
       },
       "its bones are 0 times"}};
}

/// Hands whose joints are not in the order of a hand, and hands of the wrong side.
std::vector<Spoilt> exchangedHands() {
  return {{"palm and wrist exchanged", [](auto& h) { std::swap(h.joints[palm], h.joints[wrist]); },
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
             for (int i = 0; i < 5; ++i)
               std::swap(h.joints[index_metacarpal + i], h.joints[ring_metacarpal + i]);
           },
           "in the order index, middle, ring, little"},
          {"sent as the other hand",
           [](auto& h) { h.side = h.side == Side::left ? Side::right : Side::left; }, "or mirrored?"},
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
}

TEST(HandCheck, WhatIsNoHandIsLeftOut) {
  std::vector<Spoilt> kinds = misplacedHands();
  for (const Spoilt& kind : exchangedHands()) kinds.push_back(kind);
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

}  // namespace
}  // namespace tactile_clay::hand::spoilt_hand_test
