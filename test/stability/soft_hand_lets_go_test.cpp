// After violent and impossible poses a soft hand is soon as it was before them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "hand/anatomy.h"
#include "hand/hand_pose.h"
#include "hand/neo_hookean.h"
#include "hand/soft_hands.h"
#include "support/bent_finger.h"
#include "support/pressed_hand.h"
#include "watched_hand.h"

namespace tactile_clay::hand::soft_hand_lets_go_test {
namespace {

using Eigen::Vector3d;

// Counts flesh that is inside out while the tracked hand is `hand` for some frames.
// \param k number of the first frame
InsideOut seen(SoftHands& hands, const TrackedHand& hand, int& k, int frames) {
  InsideOut inside_out;
  for (int step = 0; step < frames; ++step) {
    EXPECT_TRUE(allFinite(hands.update({hand}, stampOf(k++))));
    inside_out.see(*hands.hand(Side::right));
  }
  return inside_out;
}

// A fist in one frame, joints anywhere within a decimetre, fingers folded back, leaps across the table: in a
// possible pose after them, nothing is inside out for more than 0.2 s, and within two seconds the energy is
// that of the pose.
TEST(SoftHand, NothingLastsOfViolentAndImpossiblePoses) {
  SoftHands hands(spacing);
  const TrackedHand flat = palmDown(0.0);
  int k = settled(hands, flat, 0, 120);
  const double at_rest = hands.hand(Side::right)->energy();
  std::mt19937 random(3);
  std::vector<std::vector<TrackedHand>> attacks(4);
  attacks[0] = {palmDown(0.0, false, 1.5)};
  attacks[1] = {palmDown(0.0, false, -1.5), palmDown(0.0, false, 2.5)};
  for (int i = 0; i < 10; ++i) {
    attacks[2].push_back(scrambled(flat, 0.02, random));
    attacks[3].push_back(palmDown(i % 2 ? 0.45 : 0.0, false, i % 3));
  }
  for (std::size_t attack = 0; attack < attacks.size(); ++attack) {
    for (const TrackedHand& hand : attacks[attack]) {
      const Skin skin = hands.update({hand}, stampOf(k++));
      EXPECT_TRUE(allFinite(skin)) << attack;
    }
    const InsideOut after = seen(hands, flat, k, 120);
    std::printf("  attack %zu: %d inside out, %d frames on end\n", attack, after.maximum, after.longest);
    EXPECT_LE(after.longest, 12) << attack;
    EXPECT_EQ(hands.hand(Side::right)->inverted(), 0) << attack;
    EXPECT_LT(hands.hand(Side::right)->energy(), 1.5 * at_rest + 1e-3) << attack;
    EXPECT_EQ(hands.hand(Side::right)->restarts(), 0) << attack;
  }
}

// Distance, m, by which a touch of the palm for some frames moves a bone.
// \param k number of the first frame
double movedByATouch(SoftHands& hands, const TrackedHand& tracked, int& k, int frames) {
  const SoftHand& soft = *hands.hand(Side::right);
  const BodyPoses before = soft.bodies();
  double moved = 0.0;
  for (int step = 0; step < frames; ++step) {
    const Skin skin = hands.update({tracked}, stampOf(k));
    EXPECT_TRUE(allFinite(skin));
    std::vector<SkinForce> forces;
    for (std::size_t i = 0; i < skin.size(); ++i)
      if ((skin.position[i].cast<double>() - tracked.joints[palm].position).norm() < 0.03 &&
          skin.normal[i].y() < -0.7F)
        forces.push_back({static_cast<std::uint32_t>(i), {0.0F, 0.02F, 0.0F}});
    hands.react(stampOf(k++), forces);
    for (int b = 0; b < body_count; ++b)
      moved = std::max(moved, (soft.bodies()[b].position - before[b].position).norm());
  }
  return moved;
}

// Thumbs that are tracked beneath the palm, slowly or in a frame, leave room for flesh, and a touch of the
// palm then moves no bone far. Without limits of the joints, up to 201 tetrahedra are inside out, and a touch
// throws the thumb by 58 mm.
TEST(SoftHand, AnImpossibleThumbLeavesRoomForFlesh) {
  for (const FingerAngles& thumb :
       {FingerAngles{{0.6, 0.0, 0.0}, -0.6}, FingerAngles{{0.6, 0.5, 0.8}, -0.6},
        FingerAngles{{0.6, 0.0, 0.0}, -0.35}, FingerAngles{{1.0, 0.0, 0.0}, -1.0}})
    for (const int frames : {1, 30}) {
      SoftHands hands(spacing);
      HandPose pose;
      const TrackedHand flat = forwardKinematics(pose);
      int k = settled(hands, flat, 0, 30);
      for (int step = 1; step <= frames; ++step) {
        const double share = static_cast<double>(step) / frames;
        for (int i = 0; i < 3; ++i) pose.fingers[0].flexion[i] = share * thumb.flexion[i];
        pose.fingers[0].abduction = share * thumb.abduction;
        hands.update({forwardKinematics(pose)}, stampOf(k++));
      }
      const TrackedHand tracked = forwardKinematics(pose);
      k = settled(hands, tracked, k, 90);
      const SoftHand& soft = *hands.hand(Side::right);
      const int held = soft.inverted();
      const double moved = movedByATouch(hands, tracked, k, 30);
      const InsideOut after = seen(hands, flat, k, 60);
      std::printf("  thumb %.1f %.2f in %d frames: %d inside out, touched bones move %.1f mm\n",
                  thumb.flexion[0], thumb.abduction, frames, held, 1e3 * moved);
      EXPECT_EQ(held, 0);
      EXPECT_LT(moved, 3e-3);
      EXPECT_LE(after.longest, 12);
      EXPECT_EQ(soft.inverted(), 0);
      EXPECT_EQ(soft.restarts(), 0);
    }
}

// An impossible hand, held for a second and touched.
// \param longest successive frames with inverted flesh after it
void expectLetsGo(const TrackedHand& odd, int longest, const std::string& name) {
  SCOPED_TRACE(name);
  const TrackedHand flat = palmDown(0.0);
  SoftHands hands(spacing);
  int k = settled(hands, flat, 0, 30);
  k = settled(hands, odd, k, 60);
  EXPECT_LT(movedByATouch(hands, odd, k, 20), 0.02);
  const InsideOut after = seen(hands, flat, k, 60);
  EXPECT_LE(after.longest, longest);
  EXPECT_EQ(hands.hand(Side::right)->inverted(), 0);
  EXPECT_EQ(hands.hand(Side::right)->restarts(), 0);
}

// Joints scrambled by centimetres: bones turned aside and out of proportion. In an earlier version hundreds
// of tetrahedra stayed inside out for up to 107 frames after it, and the touch threw bones by 113 mm.
TEST(SoftHand, ScrambledJointsLetGo) {
  for (const int seed : {21, 22, 23, 24, 25, 26})
    for (const double size : {0.005, 0.02, 0.03}) {
      std::mt19937 random(seed);
      expectLetsGo(scrambled(palmDown(0.0), size, random), 12,
                   std::to_string(seed) + ", " + std::to_string(size));
    }
}

TEST(SoftHand, CollapsedJointsLetGo) {
  TrackedHand collapsed = palmDown(0.0);
  const Vector3d middle = collapsed.joints[palm].position;
  for (JointPose& joint : collapsed.joints) joint.position = middle + 1e-3 * (joint.position - middle);
  expectLetsGo(collapsed, 12, "collapsed");
}

// Every finger is within its reach, but there is no room between thumb and palm: some tetrahedra were inside
// out for as long as the joint was astray. Now the finger yields, and has its reach again when it is tracked
// elsewhere.
TEST(SoftHand, YieldsWhereAPoseLeavesFleshNoRoom) {
  struct Astray {
    Joint joint;
    Vector3d by;  // m
  };
  for (const Astray& astray : {Astray{index_proximal, {0.01906, -0.04223, 0.00192}},
                               {middle_metacarpal, {-0.03903, -0.01252, 0.06709}}}) {
    SCOPED_TRACE(joint_anatomy[astray.joint].name);
    const TrackedHand flat = palmDown(0.0);
    TrackedHand odd = flat;
    odd.joints[astray.joint].position += astray.by;
    SoftHands hands(spacing);
    int k = settled(hands, flat, 0, 30);
    const SoftHand& soft = *hands.hand(Side::right);
    EXPECT_EQ(soft.reach(0), 1.0);
    EXPECT_LE(seen(hands, odd, k, 60).longest, 12);
    EXPECT_LE(seen(hands, odd, k, 120).longest, 2);
    EXPECT_LT(soft.reach(0), 1.0);
    EXPECT_GT(soft.reach(0), 0.3);
    EXPECT_LE(seen(hands, flat, k, 60).longest, 12);
    for (int f = 0; f < finger_count; ++f) EXPECT_EQ(soft.reach(f), 1.0) << f;
    EXPECT_EQ(soft.inverted(), 0);
    EXPECT_EQ(soft.restarts(), 0);
  }
}

// Flesh may be right side out, but in a knot that only its minimum volume keeps open: one of 160 attacks left
// such a knot in an earlier version.
TEST(SoftHand, LeavesNoTangle) {
  const TrackedHand flat = palmDown(0.0);
  for (const int seed : {15, 28, 71, 72, 73, 74}) {
    SoftHands hands(spacing);
    int k = settled(hands, flat, 0, 60);
    const double at_rest = hands.hand(Side::right)->energy();
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share;
    for (const bool leaps : {false, true}) {
      for (int i = 0; i < 10; ++i) {
        const double height = i % 2 ? 0.45 * share(random) : 0.0, bend = 3.0 * share(random);
        hands.update({leaps ? palmDown(height, false, bend) : scrambled(flat, 0.02, random)}, stampOf(k++));
      }
      k = settled(hands, flat, k, 120);
      EXPECT_LT(hands.hand(Side::right)->energy(), 1.5 * at_rest + 1e-3) << seed;
      EXPECT_EQ(hands.hand(Side::right)->inverted(), 0) << seed;
    }
  }
}

// Scrambled by more than an element's size, half of the flesh is inside out. Nothing holds it, so all of it
// recovers.
TEST(NeoHookean, ScrambledFleshUntangles) {
  const FleshMesh mesh = fillCapsules(bentFinger(), 6e-3);
  const NeoHookean flesh(mesh, Elasticity::of(30e3, 0.45));
  const std::vector<double> stiffness = flesh.stiffness();
  std::vector<FleshNode> nodes = nodesOf(mesh, 0.0F);
  std::mt19937 random(2);
  std::normal_distribution<float> normal(0.0F, 5e-3F);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    nodes[n].head<3>() += Eigen::Vector3f(normal(random), normal(random), normal(random));
    nodes[n][3] = static_cast<float>(1.0 / (0.3 * stiffness[n]));
  }
  ASSERT_GT(flesh.inverted(nodes).size(), flesh.size() / 4);
  std::vector<int> squeezed;
  for (int k = 0; k < 2000; ++k) flesh.project(nodes, squeezed);
  EXPECT_TRUE(flesh.inverted(nodes).empty());
}

}  // namespace
}  // namespace tactile_clay::hand::soft_hand_lets_go_test
