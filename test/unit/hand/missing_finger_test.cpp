// A finger that the tracker does not see has no skin; the hand goes on.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "hand/anatomy.h"
#include "hand/hand_check.h"
#include "hand/hand_cleaner.h"
#include "hand/hand_pose.h"
#include "hand/kinematic_hand.h"
#include "hand/skeleton.h"
#include "hand/soft_hands.h"

namespace tactile_clay::hand::missing_finger_test {
namespace {

using namespace std::chrono_literals;
using Eigen::Vector3d;

TrackedHand wholeHand(Side side, const Vector3d& position = {0.1, 0.0, 0.2}) {
  HandPose pose;
  pose.side = side;
  pose.wrist.translation() = position;
  for (FingerAngles& finger : pose.fingers) finger.flexion = {0.3, 0.3, 0.25};
  pose.fingers[0].flexion = {0.1, 0.1, 0.2};
  pose.fingers[0].abduction = 0.3;
  return forwardKinematics(pose);
}

// A hand as sent by a tracker that has not located these joints.
TrackedHand without(int finger, TrackedHand hand, int from = 0) {
  for (int i = from; i < fingers[finger].count; ++i) hand.joints[fingers[finger][i]] = JointPose{};
  EXPECT_TRUE(judge(hand).usable);
  return hand;
}

bool isOf(const Skin& skin, std::size_t i, int finger, int from = 0) {
  return skin.region[i] >= fingers[finger][from] && skin.region[i] <= fingers[finger].tip();
}

std::size_t samplesOf(const Skin& skin, int finger, int from = 0) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < skin.size(); ++i)
    if (isOf(skin, i, finger, from)) ++count;
  return count;
}

template <typename Hands>
void expectNoSkin(Hands& hands, double max_elsewhere) {
  for (int finger = 0; finger < finger_count; ++finger)
    for (const int from : {0, 2}) {
      if (finger == 0 && from > 0) continue;
      const auto start = 1000ms * (10 * finger + from + 1);
      hands.update({}, start - 10ms);
      const TrackedHand whole = wholeHand(Side::left);
      const Skin all = hands.update({whole}, start);
      const Skin less = hands.update({without(finger, whole, from)}, start + 10ms);
      ASSERT_GT(samplesOf(all, finger), 30U);
      // The bone before the first joint that is missing ends there.
      EXPECT_EQ(samplesOf(less, finger, std::max(0, from - 1)), 0U) << finger << ", " << from;
      EXPECT_EQ(samplesOf(less, finger, 0) > 0, from > 0) << finger;
      EXPECT_GT(less.size(), all.size() / 2);
      for (std::size_t i = 0; i < less.size(); ++i) {
        ASSERT_TRUE(less.position[i].allFinite() && less.normal[i].allFinite() &&
                    less.velocity[i].allFinite());
        ASSERT_LT((less.position[i].cast<double>() - Vector3d(0.1, 0.0, 0.2)).norm(), 0.25);
        ASSERT_LT(less.velocity[i].norm(), max_elsewhere);
      }
      const Skin back = hands.update({whole}, start + 20ms);
      EXPECT_EQ(back.size(), all.size());
      for (std::size_t i = 0; i < back.size(); ++i)
        ASSERT_LT(back.velocity[i].norm(), isOf(back, i, finger) ? 3.0F : max_elsewhere);
    }
}

TEST(MissingFinger, HasNoSkinOnAKinematicHand) {
  KinematicHands hands(0.005);
  expectNoSkin(hands, 1e-6);
}

TEST(MissingFinger, HasNoSkinOnASoftHand) {
  SoftHands hands(0.005);
  expectNoSkin(hands, 1.0);  // flesh that a finger carries along
}

// Forces come back with their index in the skin that was sent, which lacks the thumb.
TEST(MissingFinger, TheForcesOnTheOthersAreFeltWhereTheyAct) {
  SoftHands hands(0.005);
  const TrackedHand hand = without(0, wholeHand(Side::right));
  Skin skin = hands.update({hand}, 0ms);
  std::uint32_t last = 0, all = 0;  // last: on the little finger
  for (all = 0; all < skin.size(); ++all)
    if (isOf(skin, all, 4, 2)) last = all;
  for (int i = 1; i <= 120; ++i) {  // to rest
    EXPECT_EQ(hands.react((i - 1) * 10ms, {{last, {0.0F, 0.0F, 1.0F}}, {all, {0.0F, 0.0F, 1.0F}}}), 1U);
    skin = hands.update({hand}, i * 10ms);
  }
  EXPECT_NEAR(hands.hand(Side::right)->force().z(), 1.0, 0.01);
  const Skin unloaded = SoftHands(0.005).update({hand}, 0ms);
  double lifted = 0.0, others = 0.0;
  for (std::size_t i = 0; i < skin.size(); ++i) {
    const double by = skin.position[i].z() - unloaded.position[i].z();
    (isOf(skin, i, 4, 2) ? lifted : others) = std::max(isOf(skin, i, 4, 2) ? lifted : others, by);
  }
  EXPECT_GT(lifted, 2.0 * others);
}

TEST(MissingFinger, IsNotMeasuredAndKeepsItsAngles) {
  const TrackedHand whole = wholeHand(Side::left);
  const Skeleton skeleton = measureSkeleton({whole});
  EXPECT_THROW(measureSkeleton({without(1, whole)}), std::invalid_argument);
  const SkeletonFit before = fitSkeleton(skeleton, whole);
  for (int finger = 0; finger < finger_count; ++finger) {
    const SkeletonFit fit = fitSkeleton(skeleton, without(finger, whole), &before.pose);
    EXPECT_LT((fit.pose.wrist.translation() - before.pose.wrist.translation()).norm(), 1e-6) << finger;
    for (int k = 0; k < skeleton_joint_count; ++k)
      EXPECT_NEAR(fit.pose.angles[k], before.pose.angles[k], 1e-5) << finger << ", " << k;
    for (const double error : fit.error) EXPECT_LT(error, 5e-3);
  }
}

TEST(MissingFinger, IsMissingAtOnceAndNewWhenItIsBack) {
  HandCleaner cleaner(CleanConfig{});
  const auto clean = [&](int i, const TrackedHand& hand) {
    TrackedFrame frame;
    frame.stamp = i * 10ms;
    frame.hands = {hand};
    cleaner.clean(frame);
    EXPECT_EQ(frame.hands.size(), 1U);
    return frame.hands.at(0);
  };
  const auto place = [](int i) { return Vector3d(0.1 + 0.005 * i, 0.0, 0.2); };  // 0.5 m/s
  HandCleaner plain(CleanConfig{});
  for (int i = 0; i < 30; ++i) {
    const TrackedHand whole = wholeHand(Side::right, place(i));
    const bool lost = i >= 10 && i < 20;
    const TrackedHand out = clean(i, lost ? without(2, whole) : whole);
    EXPECT_EQ(out.missing.any(), lost) << i;
    EXPECT_EQ(faultOf(out), "") << i;
    const bool back = i == 0 || i == 20;
    EXPECT_EQ(out.joints[middle_tip].position == whole.joints[middle_tip].position, back) << i;
    TrackedFrame frame;
    frame.stamp = i * 10ms;
    frame.hands = {whole};
    plain.clean(frame);
    // The filter of the finger starts anew and is ahead of that of the palm; SpeedLimit holds the hand back
    // for that, by a tenth of a millimetre.
    for (const int joint : {static_cast<int>(palm), static_cast<int>(index_tip)})
      EXPECT_LT((out.joints[joint].position - frame.hands.at(0).joints[joint].position).norm(),
                i <= 20 ? 1e-12 : 2e-4)
          << i;
  }
}

}  // namespace
}  // namespace tactile_clay::hand::missing_finger_test
