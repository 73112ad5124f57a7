// Long runs of the soft hand by itself: at rest, in motion, under forces that are wrong or that end.
#include "hand/soft_hands.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "hand/flesh_mesh.h"
#include "hand/hand_shape.h"
#include "hand/skin_template.h"
#include "support/pressed_hand.h"

namespace tactile_clay::hand::soft_hand_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using std::chrono::nanoseconds;

TEST(SoftHand, AtRestItIsTheKinematicHand) {
  expectKinematicAtRest(spacing);
}

TEST(SoftHand, FleshIsOfTheSizeOfAHand) {
  const SoftHandTemplate hand = makeSoftHandTemplate(Side::right, 6.5e-3, 9e-3);
  RecordProperty("nodes", static_cast<int>(hand.mesh.nodes.size()));
  RecordProperty("tetrahedra", static_cast<int>(hand.mesh.tetrahedra.size()));
  EXPECT_GT(hand.mesh.tetrahedra.size(), 5000U);
  EXPECT_LT(hand.mesh.tetrahedra.size(), 12000U);
  std::array<int, body_count> nodes{};
  for (const NodeBinding& binding : hand.bindings) nodes[binding.body] += binding.rigid;
  for (const int count : nodes) EXPECT_GE(count, 3);  // every bone holds flesh
  for (const auto& t : hand.mesh.tetrahedra) EXPECT_GT(volume(hand.mesh, t), 0.0);
}

// Without loads the skin follows bending fingers: its mean distance from the capsules stays below a
// millimetre. Soon it comes to rest.
TEST(SoftHand, FollowsTheTrackedHandAndComesToRest) {
  SoftHands hands(spacing);
  int k = settled(hands, palmDown(0.0), 0, 1);
  for (const double bend : {0.0, 1.4, 0.0}) {
    const TrackedHand hand = palmDown(0.0, false, bend);
    k = settled(hands, hand, k, 30);
    const Skin skin = hands.update({hand}, stampOf(k++));
    double mean = 0.0;
    for (const Vector3f& x : skin.position) mean += std::abs(handDistance(hand, x.cast<double>()));
    EXPECT_LT(mean / static_cast<double>(skin.size()), 1e-3) << bend;
    k = settled(hands, hand, k, 90);
    EXPECT_LT(fastest(hands.update({hand}, stampOf(k++))), 2e-3) << bend;
    EXPECT_EQ(hands.hand(Side::right)->inverted(), 0) << bend;
  }
}

TEST(SoftHand, RigidMotionIsFollowedWithoutLag) {
  SoftHands hands(spacing);
  TrackedHand hand = palmDown(0.0);
  int k = settled(hands, hand, 0, 60);
  const Vector3d velocity(0.4, -0.2, 0.3);
  Skin skin;
  for (int step = 0; step < 60; ++step) {
    for (JointPose& joint : hand.joints) joint.position += frame * velocity;
    skin = hands.update({hand}, stampOf(k++));
  }
  for (const Vector3f& v : skin.velocity) EXPECT_LT((v.cast<double>() - velocity).norm(), 0.01);
  const auto target = bodyPoses(hand, restHand(Side::right, 1.0));
  for (int b = 0; b < body_count; ++b)
    EXPECT_LT((hands.hand(Side::right)->bodies()[b].position - target[b].position).norm(), 2e-4) << b;
}

// Without loads and with the tracked hand still, energy only falls.
TEST(SoftHand, EnergyFallsWhileNothingMoves) {
  SoftHands hands(spacing);
  int k = settled(hands, palmDown(0.0, false, 1.2), 0, 60);
  const TrackedHand flat = palmDown(0.0);
  hands.update({flat}, stampOf(k++));
  double before = hands.hand(Side::right)->energy();
  for (int step = 0; step < 120; ++step) {
    hands.update({flat}, stampOf(k++));
    const double now = hands.hand(Side::right)->energy();
    EXPECT_LT(now, 1.02 * before + 1e-4) << step;
    before = now;
  }
}

TEST(SoftHand, BadForcesAreLeftOutAndStrongOnesCut) {
  SoftHands hands(spacing);
  const TrackedHand hand = palmDown(0.0);
  int k = settled(hands, hand, 0, 60);
  const std::size_t count = hands.update({hand}, stampOf(k)).size();
  const float nan = std::nanf("");
  EXPECT_EQ(hands.react(stampOf(k), {{0, {nan, 0, 0}}, {static_cast<std::uint32_t>(count), {0, 1, 0}}}), 2U);
  const SkinForce unknown{3, {0, 1, 0}};
  EXPECT_EQ(hands.react(stampOf(k) + nanoseconds(1), {unknown}), 1U);
  for (int step = 0; step < 30; ++step) {
    std::vector<SkinForce> forces;
    for (std::uint32_t i = 0; i < count; i += 7)
      forces.push_back({i, {0, step % 2 ? 1e6F : -1e6F, std::numeric_limits<float>::max()}});
    hands.react(stampOf(k), forces);
    EXPECT_TRUE(allFinite(hands.update({hand}, stampOf(++k))));
  }
  k = settled(hands, hand, ++k, 120);
  const Skin skin = hands.update({hand}, stampOf(k));
  EXPECT_TRUE(allFinite(skin));
  EXPECT_EQ(hands.hand(Side::right)->inverted(), 0);
}

TEST(SoftHand, ForcesExpire) {
  SoftHands hands(spacing);
  const TrackedHand hand = palmDown(0.0);
  int k = settled(hands, hand, 0, 30);
  hands.react(stampOf(k - 1), {{5, {0, 0.5F, 0}}});
  hands.update({hand}, stampOf(k++));
  EXPECT_GT(hands.hand(Side::right)->force().norm(), 0.1);
  settled(hands, hand, k, 7);
  EXPECT_EQ(hands.hand(Side::right)->force().norm(), 0.0);
}

// Both hands, opening and closing; pressed on a floor if `loaded`.
Skin twoHands(bool loaded) {
  SoftHands hands(spacing);
  Skin skin;
  for (int k = 0; k < 20; ++k) {
    TrackedHand right = palmDown(-0.001 * k, true, 0.05 * k), left = right;
    left.side = Side::left;
    for (JointPose& joint : left.joints) {
      joint.position = mirrored(joint.position);
      joint.orientation = mirrored(joint.orientation);
    }
    skin = hands.update({right, left}, stampOf(k));
    std::vector<SkinForce> forces;
    for (std::size_t i = 0; i < skin.size(); ++i)
      if (loaded && skin.position[i].y() < 0.0F)
        forces.push_back({static_cast<std::uint32_t>(i), -300.0F * skin.position[i].y() * Vector3f::UnitY()});
    hands.react(stampOf(k), forces);
  }
  return skin;
}

TEST(SoftHand, SameAgainBitByBit) {
  const Skin first = twoHands(true), second = twoHands(true);
  EXPECT_EQ(first.position, second.position);
  EXPECT_EQ(first.normal, second.normal);
  EXPECT_EQ(first.area, second.area);
}

// Under load, rounding decides which samples touch, so the mirror image is required only without load.
TEST(SoftHand, LeftComesFirstAndIsTheMirrorImageOfRight) {
  const Skin skin = twoHands(false);
  const std::size_t half = skin.size() / 2;
  const Vector3f flip(-1.0F, 1.0F, 1.0F);
  for (std::size_t i = 0; i < half; ++i) {
    EXPECT_EQ(skin.side[i], 0);
    EXPECT_EQ(skin.side[half + i], 1);
    EXPECT_LT((skin.position[i].cwiseProduct(flip) - skin.position[half + i]).norm(), 1e-4F);
  }
}

}  // namespace
}  // namespace tactile_clay::hand::soft_hand_test
