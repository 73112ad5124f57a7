#include "hand/reach.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>

#include "hand/anatomy.h"
#include "hand/hand_bodies.h"
#include "hand/hand_pose.h"
#include "support/hand_recording.h"

namespace tactile_clay::hand::reach_test {
namespace {

using Eigen::Vector3d;

HandPose bent(const FingerAngles& thumb, double flexion) {
  HandPose pose;
  for (FingerAngles& finger : pose.fingers) finger.flexion.fill(flexion);
  pose.fingers[0] = thumb;
  return pose;
}

double farthest(const TrackedHand& a, const TrackedHand& b) {
  double maximum = 0.0;
  for (int j = 0; j < joint_count; ++j)
    maximum = std::max(maximum, (a.joints[j].position - b.joints[j].position).norm());
  return maximum;
}

// For both sides: the palm stays, bones keep their lengths, and a second call changes nothing.
TEST(WithinReach, TurnsBackWhatIsOutsideAndOnlyThat) {
  for (const Side side : {Side::left, Side::right})
    for (HandPose pose :
         {bent({}, 0.0), bent({{0.6, 0.5, 0.8}, 0.35}, 1.5), bent({{0.6, 0.5, 0.8}, -0.6}, 0.0),
          bent({}, 2.5), bent({{-1.0, -2.0, -2.0}, 2.0}, -1.5)}) {
      const bool possible = pose.fingers[0].abduction > -0.5 && std::abs(pose.fingers[1].flexion[0]) < 1.6 &&
                            pose.fingers[1].flexion[0] > -0.1;
      pose.side = side;
      pose.scale = 0.9;
      pose.wrist =
          Eigen::Translation3d(0.1, 0.2, 0.3) * Eigen::AngleAxisd(1.0, Vector3d(1, 2, 3).normalized());
      const TrackedHand tracked = forwardKinematics(pose), hand = withinReach(tracked);
      if (possible)
        EXPECT_EQ(farthest(hand, tracked), 0.0);
      else
        EXPECT_GT(farthest(hand, tracked), 0.01);
      EXPECT_LT(farthest(withinReach(hand), hand), 1e-9);
      for (int j = 0; j < joint_count; ++j) {
        const int parent = joint_anatomy[j].parent;
        const auto length = [&](const TrackedHand& h) {
          return (h.joints[j].position - h.joints[parent].position).norm();
        };
        EXPECT_NEAR(length(hand), length(tracked), 1e-9) << j;
      }
    }
}

TEST(WithinReach, TurnsBackABoneThatIsTurnedAboutItself) {
  const TrackedHand middle = forwardKinematics(bent({{0.05, 0.0, 0.0}, 0.5}, 0.47));
  const Vector3d joint = middle.joints[ring_intermediate].position;
  const auto turned = [&](double angle) {
    TrackedHand hand = middle;
    const Eigen::AngleAxisd turn(angle, (middle.joints[ring_distal].position - joint).normalized());
    for (int j = ring_intermediate; j <= ring_tip; ++j) {
      hand.joints[j].position = joint + turn * (middle.joints[j].position - joint);
      hand.joints[j].orientation = turn * middle.joints[j].orientation;
    }
    return hand;
  };
  constexpr double maximum = 30.0 * M_PI / 180.0;
  for (const double angle : {-2.5, -1.0, -0.4, 0.3, 1.2}) {
    const TrackedHand hand = withinReach(turned(angle)),
                      expected = turned(std::clamp(angle, -maximum, maximum));
    EXPECT_LT(farthest(hand, expected), 1e-6) << angle;
    EXPECT_LT(hand.joints[ring_distal].orientation.angularDistance(expected.joints[ring_distal].orientation),
              1e-6)
        << angle;
  }
}

// The more a finger's root or bones differ from those of a hand, the less reach the finger has. Joints beyond
// a joint move with it.
TEST(WithinReach, LeadsRootsOfFingersToTheirPlace) {
  const TrackedHand possible = forwardKinematics(bent({{0.05, 0.0, 0.0}, 0.5}, 0.47));
  struct Root {
    Joint joint, tip;
    double reach;  // m
  };
  for (const Root& root : {Root{ring_proximal, ring_tip, 0.006}, {thumb_metacarpal, thumb_tip, 0.014}})
    for (const double share : {0.8, 1.25, 1.75}) {
      // The palm follows a root by a ninth; the root of the thumb is no part of the palm.
      const double follows = root.joint == thumb_metacarpal ? 1.0 : 8.0 / 9.0;
      TrackedHand off = possible;
      const Vector3d normal = possible.joints[palm].orientation * Vector3d::UnitY();
      for (int j = root.joint; j <= root.tip; ++j)
        off.joints[j].position += share * root.reach / follows * normal;
      const TrackedHand hand = withinReach(off);
      const BodyPose palm_pose = bodyPoses(off, possible)[palm_body];
      const Vector3d in_palm = possible.joints[root.joint].position - bodyCentres(possible)[palm_body];
      const Vector3d place = palm_pose.position + palm_pose.rotation * in_palm;
      const double was = (off.joints[root.joint].position - place).norm() / root.reach;
      EXPECT_NEAR((hand.joints[root.joint].position - place).norm(), std::min(was, 2.0 - was) * root.reach,
                  1e-6)
          << root.joint << ' ' << share;
      const Vector3d shift = hand.joints[root.joint].position - off.joints[root.joint].position;
      for (int j = root.joint; j <= root.tip; ++j)
        EXPECT_LT((hand.joints[j].position - off.joints[j].position - shift).norm(), 1e-9) << j;
    }
}

// The nearer a thumb's metacarpal is to that of the index finger, the less reach the thumb has. Here it is
// turned towards the index finger, or its root is nearer, each as far as in a possible hand.
TEST(WithinReach, LeadsTheThumbOutOfThePalm) {
  const TrackedHand middle = forwardKinematics(bent({{0.05, 0.0, 0.0}, 0.5}, 0.47));
  const Vector3d base = middle.joints[index_metacarpal].position;
  const Vector3d axis = (middle.joints[index_proximal].position - base).normalized();
  const auto toAxis = [&](const TrackedHand& hand) -> Vector3d {
    const Vector3d centre =
        0.5 * (hand.joints[thumb_metacarpal].position + hand.joints[thumb_proximal].position) - base;
    return centre.dot(axis) * axis - centre;
  };
  const double usual = toAxis(middle).norm();
  for (const double off : {0.2, 0.5, 0.75, 0.95}) {
    TrackedHand odd = forwardKinematics(bent({{0.05, 0.0, 0.0}, 0.1}, 0.47));
    const Vector3d shift = off * 0.014 * toAxis(odd).normalized();
    for (int j = thumb_metacarpal; j <= thumb_tip; ++j) odd.joints[j].position += shift;
    const double closeness = (usual - toAxis(odd).norm()) / (usual - 0.018);
    const TrackedHand hand = withinReach(odd);
    const double expected = std::min(off, 2.0 - std::max(1.0, closeness));
    EXPECT_NEAR((hand.joints[thumb_metacarpal].position - middle.joints[thumb_metacarpal].position).norm(),
                expected * 0.014, 1e-6)
        << off;
    EXPECT_EQ(farthest(hand, odd) > 0.0, expected < off) << off;
    EXPECT_EQ(expected < off, (off > 0.6)) << off;
  }
}

TEST(WithinReach, GivesBonesTheirLength) {
  const TrackedHand possible = forwardKinematics(bent({}, 0.5));
  const Vector3d bone = possible.joints[ring_intermediate].position - possible.joints[ring_proximal].position;
  for (const double stretch : {0.75, 0.85, 1.0, 1.2, 1.4}) {
    TrackedHand odd = possible;
    for (const Joint joint : {ring_intermediate, ring_distal, ring_tip})
      odd.joints[joint].position += (stretch - 1.0) * bone;
    const TrackedHand hand = withinReach(odd);
    const double strangeness = std::log(stretch) / std::log(stretch < 1.0 ? 0.8 : 1.25);
    const double length =
        strangeness <= 1.0 ? stretch : std::pow(stretch < 1.0 ? 0.8 : 1.25, 2.0 - strangeness);
    for (int j = 0; j < joint_count; ++j) {
      const bool beyond = j >= ring_intermediate && j <= ring_tip;
      const Vector3d expected =
          possible.joints[j].position + (beyond ? Vector3d((length - 1.0) * bone) : Vector3d::Zero());
      EXPECT_LT((hand.joints[j].position - expected).norm(), 1e-9) << stretch << ' ' << j;
    }
  }
}

TEST(WithinReach, WhatIsNoFingerRestsInTheMiddle) {
  const TrackedHand middle = forwardKinematics(bent({{0.05, 0.0, 0.0}, 0.5}, 0.47));
  for (const double stretch : {0.0, 0.2, 3.0}) {
    TrackedHand odd = forwardKinematics(bent({{0.05, 0.0, 0.0}, 0.5}, 1.2));
    for (const Joint joint : {ring_intermediate, ring_distal, ring_tip})
      odd.joints[joint].position +=
          (stretch - 1.0) * (odd.joints[ring_intermediate].position - odd.joints[ring_proximal].position);
    const TrackedHand hand = withinReach(odd);
    for (int j = ring_metacarpal; j <= ring_tip; ++j)
      EXPECT_LT((hand.joints[j].position - middle.joints[j].position).norm(), 1e-6) << stretch << ' ' << j;
    EXPECT_EQ(hand.joints[index_tip].position, odd.joints[index_tip].position);
  }
}

// If three fingers are wrong, the palm is wrong, too, and the other fingers have no more reach than the
// third.
TEST(WithinReach, AStrangePalmTakesReachFromAll) {
  const TrackedHand middle = forwardKinematics(bent({{0.05, 0.0, 0.0}, 0.5}, 0.47));
  const TrackedHand possible = forwardKinematics(bent({{0.05, 0.0, 0.0}, -0.1}, 0.47));
  const auto thumb = [](const TrackedHand& hand) -> Vector3d {
    return (hand.joints[thumb_proximal].position - hand.joints[thumb_metacarpal].position).normalized();
  };
  const auto angle = [&](const TrackedHand& hand) { return std::acos(thumb(hand).dot(thumb(middle))); };
  TrackedHand odd = possible;
  const double stretch = std::pow(1.25, 1.6);
  int strange = 0;
  for (const auto& [joint, next, tip] : {std::array{index_proximal, index_intermediate, index_tip},
                                         {middle_proximal, middle_intermediate, middle_tip},
                                         {ring_proximal, ring_intermediate, ring_tip}}) {
    const Vector3d bone = possible.joints[next].position - possible.joints[joint].position;
    for (int j = next; j <= tip; ++j) odd.joints[j].position += (stretch - 1.0) * bone;
    const TrackedHand hand = withinReach(odd);
    if (++strange < 3) {
      EXPECT_EQ(thumb(hand), thumb(odd));
      continue;
    }
    constexpr double reach = 0.4 * 46.0 * M_PI / 180.0;
    EXPECT_GT(angle(odd), 1.5 * reach);
    EXPECT_LT(angle(hand), 1.001 * reach);
    EXPECT_GT(angle(hand), 0.8 * reach);
  }
}

// A finger that is given none of its reach rests in the middle; one that is given half bends half as far.
TEST(WithinReach, AFingerHasTheShareThatItIsGiven) {
  const TrackedHand middle = forwardKinematics(bent({{0.05, 0.0, 0.0}, 0.5}, 0.47));
  const double bend = 75.0 * M_PI / 180.0;
  const TrackedHand bent_hand = forwardKinematics(bent({{0.05, 0.0, 0.0}, 0.5}, 0.47 + bend));
  const TrackedHand half = forwardKinematics(bent({{0.05, 0.0, 0.0}, 0.5}, 0.47 + 0.5 * bend));
  const TrackedHand hand = withinReach(bent_hand, {1.0, 1.0, 0.0, 0.5, 1.0});
  const auto off = [&](const TrackedHand& expected, int finger) {
    double maximum = 0.0;
    for (int j = fingers[finger].first; j <= fingers[finger].tip(); ++j)
      maximum = std::max(maximum, (hand.joints[j].position - expected.joints[j].position).norm());
    return maximum;
  };
  for (const int finger : {0, 1, 4}) EXPECT_LT(off(bent_hand, finger), 1e-6) << finger;
  EXPECT_LT(off(middle, 2), 1e-6);
  EXPECT_LT(off(half, 3), 1e-6);
}

// On the way from a possible hand to an impossible one the correction grows, but never jumps: with steps a
// quarter as long, no step changes it by much more than a quarter as much.
TEST(WithinReach, LeadsWithoutLeaps) {
  const TrackedHand possible = forwardKinematics(bent({{0.3, 0.2, 0.2}, 0.2}, 0.9));
  for (const int seed : {1, 2, 3, 4}) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::array<Vector3d, joint_count> way;  // m
    for (Vector3d& v : way) v = 0.02 * Vector3d(normal(random), normal(random), normal(random));
    const auto longest_move = [&](int steps) {
      double maximum = 0.0;
      TrackedHand before = withinReach(possible);
      for (int k = 1; k <= steps; ++k) {
        TrackedHand odd = possible;
        for (int j = 0; j < joint_count; ++j) odd.joints[j].position += k * way[j] / steps;
        const TrackedHand hand = withinReach(odd);
        maximum = std::max(maximum, farthest(hand, before));
        before = hand;
      }
      return maximum;
    };
    EXPECT_LT(longest_move(16000), 0.3 * longest_move(4000)) << seed;
  }
}

TEST(WithinReach, RecordedHandsAre) {
  int hands = 0, changed = 0;
  for (const char* name : hand_recordings) {
    const auto frames = recordedFrames(name);
    if (!frames) GTEST_SKIP() << handRecording(name) << " is not here";
    for (const TrackedFrame& frame : *frames)
      for (const TrackedHand& hand : frame.hands) {
        const double maximum = farthest(withinReach(hand), hand);
        EXPECT_LT(maximum, 5e-4) << name;
        ++hands;
        changed += maximum > 0.0;
      }
  }
  std::printf("  %d of %d recorded hands turned back\n", changed, hands);
  EXPECT_LT(changed, hands / 100);
}

}  // namespace
}  // namespace tactile_clay::hand::reach_test
