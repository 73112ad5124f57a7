#include "hand/choreography.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "hand/hand_check.h"
#include "played_score.h"

namespace tactile_clay::hand::choreography_test {
namespace {

using Eigen::Vector3d;
using namespace played_score;

void expectPlayable(const Score& score) {
  for (const auto& keys : score.hands) {
    for (std::size_t i = 0; i < keys.size(); ++i) {
      EXPECT_TRUE(withinLimits(keys[i].pose)) << i;
      EXPECT_EQ(i == 0 || keys[i].time >= keys[i - 1].time, true) << i;
    }
  }
  play(
      score,
      [](double t, const TrackedFrame& frame, const Skin& skin) {
        EXPECT_EQ(frame.frame_id, "world");
        EXPECT_NEAR(std::chrono::duration<double>(frame.stamp).count(), t, 1e-9);
        for (const TrackedHand& hand : frame.hands) EXPECT_EQ(faultOf(hand), "");
        for (const Eigen::Vector3f& v : skin.velocity) ASSERT_LT(v.norm(), 1.0F) << t;
        EXPECT_GT(lowest(frame), 0.002) << t;  // above the table
      },
      16e-3);
}

TEST(Choreography, EveryScoreIsPlayable) {
  Potter covering;
  covering.lean = 0.175;
  covering.top = 0.068;
  for (const Score& score : {flatPress(), pressThumb(), potter(), potter(covering),
                             inTurn({pressFinger(), pinch(), roll(), knead()})})
    expectPlayable(score);
}

TEST(Choreography, KneadingPressesWithHeelPalmAndFingersToItsDepth) {
  const Knead parameters;
  const Score score = knead(parameters);
  EXPECT_NEAR(score.duration(), 12.0, 1.0);
  for (const double t : {0.0, score.duration()})  // outside, beyond the tracker's sight
    for (const TrackedHand& hand : score.sample(t).hands) EXPECT_LT(hand.joints[palm].position.x(), -0.3);
  double deepest = 1.0;
  double first = 0.0;
  double last = 0.0;
  std::set<int> touching;
  play(score, [&](double t, const TrackedFrame& frame, const Skin& skin) {
    EXPECT_EQ(frame.hands.size(), 2U);
    if (t == 0.0) first = lowest(frame);
    last = lowest(frame);
    deepest = std::min(deepest, last);
    double apart = 1.0;
    for (std::size_t i = 0; i < skin.size(); ++i) {
      if (skin.position[i].z() < parameters.block_height &&
          skin.position[i].head<2>().cwiseAbs().maxCoeff() < 0.12F)
        touching.insert(skin.region[i]);
      if (skin.side[i] == 0) apart = std::min<double>(apart, skin.position[i].y());
    }
    EXPECT_GT(apart, 0.0) << t;  // the left hand stays on its side, and the right one by symmetry
  });
  EXPECT_NEAR(deepest, parameters.block_height - parameters.depth, 5e-4);
  EXPECT_GT(first, parameters.block_height + 0.03);
  EXPECT_GT(last, parameters.block_height + 0.03);
  for (const Joint joint : {thumb_metacarpal, palm, middle_metacarpal, ring_metacarpal, index_distal,
                            ring_distal, middle_intermediate})
    EXPECT_EQ(touching.count(joint), 1U) << joint_anatomy[joint].name;
}

TEST(Choreography, ThePottersHandsAreMirrorImagesAndCloseToTheirDepth) {
  const Potter parameters;
  const Score score = potter(parameters);
  EXPECT_NEAR(score.duration(), 8.0, 1e-9);
  double closest = 1.0;
  double first = 0.0;
  play(score, [&](double t, const TrackedFrame& frame, const Skin& skin) {
    double gap = 1.0;
    for (const Eigen::Vector3f& x : skin.position) gap = std::min<double>(gap, x.head<2>().norm());
    if (t == 0.0) first = gap;
    closest = std::min(closest, gap);
    for (int joint = 0; joint < joint_count; ++joint) {
      Vector3d left = frame.hands[0].joints[joint].position;
      left.y() = -left.y();
      EXPECT_LT((left - frame.hands[1].joints[joint].position).norm(), 1e-9);
    }
  });
  EXPECT_NEAR(closest, parameters.radius - parameters.depth, 1e-3);
  EXPECT_NEAR(first, parameters.radius + 0.04, 1e-3);
}

TEST(Choreography, LeaningPottersHandsCloseToACone) {
  Potter parameters;
  parameters.lean = 0.3;
  double closest = 1.0;
  play(potter(parameters), [&](double, const TrackedFrame& /*frame*/, const Skin& skin) {
    for (const Eigen::Vector3f& x : skin.position)
      closest = std::min(closest,
                         x.head<2>().norm() + (x.z() - 0.5 * parameters.height) * std::tan(parameters.lean));
  });
  EXPECT_NEAR(closest, parameters.radius - parameters.depth, 1e-3);
}

TEST(Choreography, ThePottersThumbsPressTheTopWhileTheHandsHoldTheSides) {
  Potter parameters;
  parameters.top = 0.068;
  const Score score = potter(parameters);
  double lowest_thumb = 1.0, closest_hand = 1.0;
  play(score, [&](double t, const TrackedFrame& /*frame*/, const Skin& skin) {
    double thumb = 1.0, hand = 1.0;  // height above the inner clay, distance from the axis
    for (std::size_t i = 0; i < skin.size(); ++i) {
      const double distance = skin.position[i].head<2>().norm();
      if (skin.region[i] >= thumb_metacarpal && skin.region[i] <= thumb_tip) {
        if (distance < 0.6 * parameters.radius) thumb = std::min<double>(thumb, skin.position[i].z());
      } else if (skin.region[i] > thumb_tip) {
        hand = std::min(hand, distance);
      }
    }
    lowest_thumb = std::min(lowest_thumb, thumb);
    if (t < 4.5) {
      EXPECT_GT(thumb, parameters.top + 0.01) << t;
    }
    if (t > 7.5 && t < 9.0) {
      EXPECT_NEAR(thumb, parameters.top, 1.5e-3) << t;
      closest_hand = std::min(closest_hand, hand);
    }
  });
  EXPECT_NEAR(lowest_thumb, parameters.top, 1.5e-3);
  EXPECT_GT(closest_hand, parameters.radius - parameters.depth);
  EXPECT_LT(closest_hand, parameters.radius);
  parameters.top = 0.2;
  EXPECT_THROW(potter(parameters), std::invalid_argument);
}

TEST(Choreography, NoiseRepeatsIsWhiteAndKeepsBones) {
  Score score = pressFinger();
  const TrackedFrame clean = score.sample(0.1);
  score.noise = {1e-4, 1e-3, 7};
  const TrackedFrame once = score.sample(0.1);
  EXPECT_EQ(once.hands[0].joints[index_tip].position, score.sample(0.1).hands[0].joints[index_tip].position);
  score.noise.seed = 8;
  EXPECT_NE(once.hands[0].joints[index_tip].position, score.sample(0.1).hands[0].joints[index_tip].position);
  EXPECT_NEAR(personScale(once.hands[0]), 1.05, 1e-9);
  double squares = 0.0;
  constexpr int count = 2000;
  for (int i = 0; i < count; ++i)  // the hand rests for the first 0.3 s
    squares +=
        (score.sample(1e-4 * i).hands[0].joints[wrist].position - clean.hands[0].joints[wrist].position)
            .squaredNorm();
  EXPECT_NEAR(std::sqrt(squares / (3 * count)), 1e-4, 4e-6);
}

TEST(Choreography, RefusesParametersThatMakeNoMotion) {
  PressFinger still;
  still.speed = 0.0;
  EXPECT_THROW(pressFinger(still), std::invalid_argument);
  Knead through;
  through.depth = 0.05;
  EXPECT_THROW(knead(through), std::invalid_argument);
  Potter inside;
  inside.depth = 0.06;
  EXPECT_THROW(potter(inside), std::invalid_argument);
}

// Smallest distance of a point of the thumb's skin from the skin of index and middle finger, in the block.
double gripWidth(const TrackedHand& hand) {
  const Eigen::Vector3d fingers = 0.5 * (hand.joints[index_tip].position + hand.joints[middle_tip].position);
  return (fingers - hand.joints[thumb_tip].position).norm() - hand.joints[thumb_tip].radius -
         hand.joints[index_tip].radius;
}

TEST(Choreography, APinchClosesToItsWidthAroundTheBlock) {
  Pinch parameters;
  parameters.centre = {0.02, -0.03};
  const Score score = pinch(parameters);
  double narrowest = 1.0, widest = 0.0;
  for (double t = 0.0; t <= score.duration(); t += 0.01) {
    const TrackedHand hand = score.sample(t).hands.at(0);
    narrowest = std::min(narrowest, gripWidth(hand));
    widest = std::max(widest, gripWidth(hand));
    if (std::abs(gripWidth(hand) - (parameters.width - parameters.depth)) > 1e-4) continue;
    // Closed: around the block's centre, and below its top.
    const Eigen::Vector3d middle =
        0.25 * (hand.joints[index_tip].position + hand.joints[middle_tip].position) +
        0.5 * hand.joints[thumb_tip].position;
    EXPECT_LT((middle.head<2>() - parameters.centre).norm(), 1e-4);
    EXPECT_LT(hand.joints[index_tip].position.z(), parameters.block_height);
    EXPECT_LT(hand.joints[thumb_tip].position.z(), parameters.block_height);
  }
  EXPECT_NEAR(narrowest, parameters.width - parameters.depth, 1e-4);
  EXPECT_GT(widest, parameters.width + 0.005);
}

TEST(Choreography, ARollStaysAtItsDepthAndGoesToAndFro) {
  const Roll parameters;
  const Score score = roll(parameters);
  double left = 1.0, right = -1.0, lowest_palm = 1.0;
  for (double t = 0.0; t <= score.duration(); t += 0.01) {
    const Eigen::Vector3d palm_at = score.sample(t).hands.at(0).joints[palm].position;
    lowest_palm = std::min(lowest_palm, palm_at.z());
    left = std::min(left, palm_at.x());
    right = std::max(right, palm_at.x());
  }
  EXPECT_NEAR(right - left, 2.0 * parameters.travel, 1e-9);
  const double start = score.sample(0.0).hands.at(0).joints[palm].position.z();
  EXPECT_NEAR(start - lowest_palm, parameters.approach + parameters.depth, 1e-9);
}

TEST(Choreography, ScoresInTurnAreThoseScores) {
  const Score press = pressFinger(), two = knead(), all = inTurn({press, two, press}, 0.5);
  EXPECT_DOUBLE_EQ(all.duration(), 2.0 * press.duration() + two.duration() + 1.0);
  const double second = press.duration() + 0.5;
  for (double t = 0.0; t < two.duration(); t += 0.1) {
    const auto a = two.sample(t), b = all.sample(second + t);
    ASSERT_EQ(b.hands.size(), 2U);
    for (const TrackedHand& hand : a.hands) {
      const auto same = std::find_if(b.hands.begin(), b.hands.end(),
                                     [&](const TrackedHand& other) { return other.side == hand.side; });
      EXPECT_LT((same->joints[index_tip].position - hand.joints[index_tip].position).norm(), 1e-9) << t;
    }
  }
}

}  // namespace
}  // namespace tactile_clay::hand::choreography_test
