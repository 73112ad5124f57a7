// Long runs of the soft hand: its state after seconds of contact, of violence and of rest.
#include "hand/soft_hands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "hand/anatomy.h"
#include "hand/flesh_mesh.h"
#include "hand/hand_pose.h"
#include "hand/hand_shape.h"
#include "hand/neo_hookean.h"
#include "hand/skin_template.h"
#include "support/hand_recording.h"
#include "support/pressed_hand.h"
#include "support/setups.h"

namespace tactile_clay::hand {
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

// The tracked finger goes 10 mm into a floor of 1 kN/m per sample: the virtual finger stays on it.
TEST(SoftHand, FingerStopsAtAStiffFloor) {
  Press press(1000.0, true);
  press.approach(-0.01);
  for (int k = 0; k < 60; ++k) press.frame(-0.01);
  EXPECT_LT(press.depth, 2e-3);
  EXPECT_GT(press.force, 1.0);
  EXPECT_LT(press.force, 30.0);
  // The springs of the bones carry the force of the floor.
  EXPECT_NEAR(press.soft().force().y() / press.force, 1.0, 0.02);
  const auto target = bodyPoses(press.tracked, restHand(Side::right, 1.0));
  const Couplings couplings;
  double springs = 0.0;
  for (int b = 0; b < body_count; ++b)
    springs += (b == palm_body ? couplings.palm : couplings.finger) *
               (press.soft().bodies()[b].position.y() - target[b].position.y());
  EXPECT_NEAR(springs / press.force, 1.0, 0.05);
  constexpr int index_tip_bone = 6;
  EXPECT_GT(press.soft().bodies()[index_tip_bone].position.y() - target[index_tip_bone].position.y(), 1e-3);
}

// Root mean square of the part of a force above 20 Hz, over the mean of the force.
// \param force N, of each frame
double buzz(const std::vector<double>& force) {
  const auto count = static_cast<int>(force.size());
  double mean = 0.0, power = 0.0;
  for (const double f : force) mean += f / count;
  for (int bin = 1; bin <= count / 2; ++bin) {
    if (bin / (count * frame) <= 20.0) continue;
    double re = 0.0, im = 0.0;
    for (int k = 0; k < count; ++k) {
      re += (force[k] - mean) * std::cos(2.0 * M_PI * bin * k / count);
      im += (force[k] - mean) * std::sin(2.0 * M_PI * bin * k / count);
    }
    power += 2.0 * (re * re + im * im) / (static_cast<double>(count) * count);
  }
  return std::sqrt(power) / mean;
}

// The haptic loop at rest, over floors from soft to stiff; also 20 mm deep, where a finger gets up to 8 N and
// its pad is flat.
TEST(SoftHand, LoopIsQuietOnSoftAndStiffFloors) {
  for (const bool pointing : {true, false})
    for (const auto& [stiffness, depth] :
         {std::pair{30.0, 0.01}, {300.0, 0.01}, {1000.0, 0.01}, {1000.0, 0.015}, {1000.0, 0.02}}) {
      Press press(stiffness, pointing);
      press.approach(-depth);
      for (int k = 0; k < 90; ++k) press.frame(-depth);
      std::vector<double> force;
      for (int k = 0; k < 120; ++k) {
        press.frame(-depth);
        force.push_back(press.force);
        ASSERT_GT(press.force, 0.1);
      }
      EXPECT_LT(buzz(force), 0.05) << stiffness << ' ' << depth << (pointing ? " finger" : " palm");
    }
}

// A pad flattens: contact area grows with force, for small loads between Hertz's F^(2/3) and a flat punch's
// F^0.
TEST(SoftHand, ContactAreaGrowsWithForce) {
  std::vector<double> area, force;
  for (const double press_depth : {0.001, 0.003, 0.006}) {
    Press press(300.0, false);
    press.approach(-press_depth);
    for (int k = 0; k < 60; ++k) press.frame(-press_depth);
    area.push_back(press.area);
    force.push_back(press.force);
  }
  for (int k = 0; k + 1 < 3; ++k) {
    EXPECT_GT(force[k + 1], force[k]);
    EXPECT_GT(area[k + 1], area[k]);
    const double exponent = std::log(area[k + 1] / area[k]) / std::log(force[k + 1] / force[k]);
    EXPECT_GT(exponent, 0.1);
    EXPECT_LT(exponent, 1.0);
  }
}

TEST(SoftHand, LeavesWithoutSticking) {
  for (const double friction : {0.0, 0.6}) {
    Press press(1000.0, true, friction);
    press.approach(-0.008);
    for (int k = 0; k < 60; ++k) press.frame(-0.008);
    ASSERT_GT(press.force, 0.5);
    for (int k = 1; k <= 12; ++k) press.frame(-0.008 + 0.005 * k);
    EXPECT_EQ(press.force, 0.0);
    EXPECT_EQ(press.soft().force().norm(), 0.0);
    for (int k = 0; k < 30; ++k) press.frame(0.052);
    SoftHands fresh(spacing);
    settled(fresh, press.tracked, 0, 121);
    const Skin free = fresh.update({press.tracked}, stampOf(121));
    double mean = 0.0;
    for (std::size_t i = 0; i < free.size(); ++i) mean += (free.position[i] - press.skin.position[i]).norm();
    EXPECT_LT(mean / static_cast<double>(free.size()), 5e-4);
  }
}

// How many tetrahedra of flesh were inside out, and in how many successive frames.
class InsideOut {
 public:
  void see(const SoftHand& hand) {
    const int now = hand.inverted();
    maximum = std::max(maximum, now);
    on_end_ = now > 0 ? on_end_ + 1 : 0;
    longest = std::max(longest, on_end_);
  }
  int maximum = 0, longest = 0;  // tetrahedra, frames

 private:
  int on_end_ = 0;
};

// With up to 2.6 N on a finger and 7 N on a flat hand, which come to rest 10 mm deep, flesh is inside out in
// no frame. At 15 mm, with 5 and 16 N, it is for at most three frames.
TEST(SoftHand, FleshPressedOnAFloorIsNotInsideOut) {
  for (const bool pointing : {true, false})
    for (const double stiffness : {300.0, 1000.0})
      for (const double depth : {0.01, 0.015}) {
        Press press(stiffness, pointing, 0.6);
        InsideOut inside_out;
        for (int k = 0; k < 120; ++k) {
          press.frame(std::max(-depth, 0.01 - 0.03 * k * frame));
          inside_out.see(press.soft());
        }
        ASSERT_GT(press.force, 1.0);
        const char* part = pointing ? "finger" : "palm";
        EXPECT_LE(inside_out.longest, depth > 0.01 ? 3 : 0) << part << ' ' << stiffness << ' ' << depth;
      }
}

clay::Material hardWax() {
  clay::Material wax;
  wax.density = 1000.0;
  wax.stiffness = 1e6;
  wax.yield_strain = 0.1;
  wax.friction = 0.8;
  return wax;
}

// A hand over a block of hard wax, or another material, whose top is at y = 0; `aside` moves it, m.
class WaxPress {
 public:
  explicit WaxPress(bool pointing, double aside = 0.0, const clay::Material& material = hardWax())
      : hands(spacing), pointing_(pointing) {
    constexpr double clay_spacing = 0.005;
    config_.gravity = {0.0, -9.81, 0.0};
    config_.threads = 1;
    const Eigen::Matrix3d y_up = Eigen::AngleAxisd(-0.5 * M_PI, Vector3d::UnitX()).toRotationMatrix();
    const TrackedHand above = palmDown(0.0, pointing);
    const auto lowest = std::min_element(
        above.joints.begin(), above.joints.end(),
        [](const auto& a, const auto& b) { return a.position.y() - a.radius < b.position.y() - b.radius; });
    const Vector3d foot(lowest->position.x() + aside, -8 * clay_spacing, lowest->position.z());
    const int length = pointing ? 10 : 20, width = pointing ? 10 : 8;
    clay_.emplace(config_, std::vector<clay::Material>{material},
                  clay::block(length, width, 8, clay_spacing, foot, y_up));
    table_ = clay::ground();
    table_.pose.linear() = y_up;
    table_.pose.translation() = Vector3d(0.0, foot.y() - 0.1, 0.0);
  }

  /// Makes a frame with the tracked hand's lowest point at `height` over the wax, m.
  void frame(double height) {
    tracked = palmDown(height, pointing_);
    const Skin skin = hands.update({tracked}, stampOf(count_));
    clay_->advance(skin, {table_}, config_.frame);
    Vector3f sum = Vector3f::Zero();
    for (const SkinForce& f : clay_->skinForces()) sum += f.force;
    clay_force = sum.norm();
    fastest = hand::fastest(skin);
    hands.react(stampOf(count_++), clay_->skinForces());
    inside_out.see(soft());
  }
  /// Comes from 10 mm over the wax to `height`, at 50 mm/s.
  void approach(double height) {
    constexpr double speed = 0.05;  // m/s
    const int down = static_cast<int>(std::ceil((0.01 - height) / (speed * hand::frame)));
    for (int k = 0; k < down; ++k) frame(std::max(height, 0.01 - speed * k * hand::frame));
  }
  const SoftHand& soft() const { return *hands.hand(Side::right); }

  SoftHands hands;
  TrackedHand tracked;
  InsideOut inside_out;
  double clay_force = 0.0;  // N
  double fastest = 0.0;     // m/s, of the skin

 private:
  bool pointing_;
  int count_ = 0;
  clay::ClayConfig config_;
  std::optional<clay::Clay> clay_;
  clay::Solid table_;
};

// A hand goes 10 mm into hard wax at 50 mm/s, where the forces of the clay come late and in jolts, rests for
// two seconds, and goes out again.
TEST(SoftHand, FleshPressedIntoHardWaxDoesNotStayInsideOut) {
  constexpr double depth = 0.01, speed = 0.05;
  for (const bool pointing : {true, false}) {
    WaxPress press(pointing);
    for (int k = 0; k < 180; ++k) {
      const double down = std::max(-depth, 0.01 - speed * k * frame), up = -depth + speed * (k - 144) * frame;
      press.frame(std::max(down, up));
      if (k == 140) {
        EXPECT_GT(press.clay_force, 1.0) << pointing;
      }
    }
    EXPECT_LE(press.inside_out.longest, 3) << pointing;
    EXPECT_EQ(press.soft().restarts(), 0);
  }
}

// When the clay releases the finger, the finger must not hover over it while it is tracked deeper: that would
// be felt as silence. With loads of zero force that lasted 12 frames it hovered in a fifth of the frames,
// fell into the clay with up to 20 N, and left flesh behind in it.
TEST(SoftHand, FingerStaysOnFirmClayAndLeavesIt) {
  constexpr double depth = 0.01, acceleration = 0.4;  // m, m/s^2
  int frames = 0, silent = 0;
  for (const double aside : {0.0, 0.7e-3, 1.9e-3, 3.1e-3}) {
    WaxPress press(true, aside, clay::firmClay());
    press.approach(-1e-3);
    for (int k = 0; k < 48; ++k, ++frames) {
      press.frame(std::max(-depth, -1e-3 - 0.03 * k * frame));
      silent += press.clay_force < 0.05 ? 1 : 0;
    }
    for (int k = 1; k <= 30; ++k) press.frame(-depth + 0.5 * acceleration * frame * frame * k * k);
    EXPECT_EQ(press.clay_force, 0.0) << aside;
    EXPECT_EQ(press.soft().force().norm(), 0.0) << aside;
    EXPECT_LE(press.inside_out.longest, 3) << aside;
  }
  std::printf("  silent in %d of %d frames\n", silent, frames);
  EXPECT_LT(silent, frames / 10);
}

// Force on a hand, and motion of its skin, in the last of two seconds for which it is held `depth` m in hard
// wax.
struct Held {
  double mean = 0.0, deviation = 0.0;  // N, of the force on the hand
  double clay = 0.0;                   // N, mean of what the wax gives
  double fastest = 0.0;                // m/s, of the skin
};
Held heldInWax(WaxPress& press, double depth) {
  constexpr int rest = 120, last = 60;
  press.approach(-depth);
  for (int k = 0; k < rest - last; ++k) press.frame(-depth);
  Held held;
  std::vector<double> force;
  for (int k = 0; k < last; ++k) {
    press.frame(-depth);
    force.push_back(press.soft().force().norm());
    held.clay += press.clay_force / last;
    held.fastest = std::max(held.fastest, press.fastest);
  }
  for (const double f : force) held.mean += f / last;
  for (const double f : force) held.deviation += (f - held.mean) * (f - held.mean) / last;
  held.deviation = std::sqrt(held.deviation);
  std::printf("  %.0f mm in wax: hand %.2f +- %.3f N, wax %.1f N, skin up to %.2f mm/s\n", 1e3 * depth,
              held.mean, held.deviation, held.clay, 1e3 * held.fastest);
  return held;
}

// However deep the tracked hand goes, the force of the wax is never larger than the pull of all couplings,
// 100 N, and the hand leaves without sticking. With springs without a limit and loads cut to 50 N, the hand
// was driven on until the wax pressed with 2.7 kN.
TEST(SoftHand, IsHeldByHardWaxAndLeaves) {
  for (const double depth : {0.03, 0.04, 0.06}) {
    WaxPress press(false);
    const Held held = heldInWax(press, depth);
    EXPECT_GT(held.mean, 20.0) << depth;
    EXPECT_LT(held.clay, 100.0) << depth;
    for (int k = 0; k < 30; ++k) press.frame(-depth + 0.01 * k);
    EXPECT_EQ(press.clay_force, 0.0) << depth;
    EXPECT_EQ(press.soft().force().norm(), 0.0) << depth;
    EXPECT_EQ(press.soft().restarts(), 0) << depth;
  }
}

// Two seconds after a hand came to this depth in hard wax, the force on it does not buzz. Later a finger may
// slide to another place, so one of the five seconds may be worse: in 30 runs this happened in three of the
// 180 seconds.
void expectNoBuzzInWax(bool pointing, double depth, double aside) {
  constexpr int rest = 120, second = 60;
  WaxPress press(pointing, aside);
  press.approach(-depth);
  for (int k = 0; k < rest; ++k) press.frame(-depth);
  std::vector<double> each;
  InsideOut inside_out;
  for (int s = 0; s < 5; ++s) {
    std::vector<double> force;
    for (int k = 0; k < second; ++k) {
      press.frame(-depth);
      inside_out.see(press.soft());
      force.push_back(press.soft().force().norm());
      ASSERT_GT(force.back(), 1.0);
    }
    each.push_back(buzz(force));
  }
  std::sort(each.begin(), each.end());
  std::printf("  %s, %.0f mm in wax: above 20 Hz %.2f %% of the force, once %.2f %%\n",
              pointing ? "finger" : "palm", 1e3 * depth, 1e2 * each[3], 1e2 * each[4]);
  EXPECT_LT(each[3], 0.05) << depth << ' ' << aside;
  EXPECT_LE(inside_out.longest, 3) << depth << ' ' << aside;
}

TEST(SoftHand, FingerDeepInHardWaxDoesNotBuzz) {
  for (const double aside : {2e-4, 1e-3})
    for (const double depth : {0.015, 0.03, 0.06}) expectNoBuzzInWax(true, depth, aside);
}

TEST(SoftHand, FlatHandDeepInHardWaxDoesNotBuzz) {
  for (const double depth : {0.02, 0.03, 0.04}) expectNoBuzzInWax(false, depth, 2e-4);
}

void expectRestInWax(bool pointing, double depth, double aside) {
  WaxPress press(pointing, aside);
  const Held held = heldInWax(press, depth);
  EXPECT_LT(held.deviation, 0.02 * held.mean) << depth << ' ' << aside;
  EXPECT_LT(held.fastest, 2e-3) << depth << ' ' << aside;
}

// Twelve of twelve runs are within 0.03 % of the force. With the last bits of the clay changed, one of 42 was
// not; these bits decide which one.
TEST(SoftHand, DISABLED_FlatHandComesToRestDeepInHardWax) {
  for (const double aside : {0.0, 1e-6, 1e-4, 3e-4})
    for (const double depth : {0.02, 0.03, 0.04}) expectRestInWax(false, depth, aside);
}

// Of 20 runs 9 are within 0.3 % of the force, 13 within 2 %, 4 beyond 5 % and at most 30 %; samples of the
// fingertip then jump.
TEST(SoftHand, DISABLED_FingerComesToRestDeepInHardWax) {
  for (const double aside : {0.0, 1e-6, 1e-4, 3e-4})
    for (const double depth : {0.015, 0.02, 0.03, 0.04, 0.06}) expectRestInWax(true, depth, aside);
}

// A tracker finds the hand 20 mm inside of hard wax. The clay presses it with hundreds of newtons in one
// frame; the hand takes at most the force with which a hand can press.
TEST(SoftHand, AppearsInsideOfHardWaxWithoutAJolt) {
  for (const bool pointing : {true, false}) {
    WaxPress press(pointing);
    double strongest = 0.0, clays = 0.0;
    for (int k = 0; k < 30; ++k) {
      press.frame(-0.02);
      strongest = std::max(strongest, press.soft().force().norm());
      clays = std::max(clays, press.clay_force);
    }
    RecordProperty(pointing ? "finger_clay_N" : "palm_clay_N", static_cast<int>(clays));
    EXPECT_LT(strongest, 60.0) << pointing;
    EXPECT_TRUE(allFinite(press.hands.update({press.tracked}, stampOf(30)))) << pointing;
  }
}

// Joints at places that no hand has, off by about `size` m and turned at random.
TrackedHand scrambled(TrackedHand hand, double size, std::mt19937& random) {
  std::normal_distribution<double> normal;
  for (JointPose& joint : hand.joints) {
    joint.position += size * Vector3d(normal(random), normal(random), normal(random));
    joint.orientation =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
  }
  return hand;
}

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

// 0.3 s after the tracked hand moved along a way and stopped, nothing is inside out, and soon the skin is at
// rest.
// \param still m/s
void expectHeldRightSideOut(const std::vector<TrackedHand>& way, const std::string& name,
                            double still = 5e-3) {
  SoftHands hands(spacing);
  int k = settled(hands, palmDown(0.0), 0, 30);
  for (const TrackedHand& tracked : way) hands.update({tracked}, stampOf(k++));
  k = settled(hands, way.back(), k, 18);
  InsideOut held;
  double moving = 0.0;  // m/s
  for (int step = 0; step < 60; ++step) {
    const Skin skin = hands.update({way.back()}, stampOf(k++));
    held.see(*hands.hand(Side::right));
    if (step >= 30) moving = std::max(moving, static_cast<double>(fastest(skin)));
  }
  EXPECT_EQ(held.maximum, 0) << name;
  EXPECT_LT(moving, still) << name;
  EXPECT_EQ(hands.hand(Side::right)->restarts(), 0) << name;
}

// Fingers are bent to the ends of their reach and beyond, in a frame or slowly. In an earlier version, 2 to
// 17 tetrahedra in their folds stayed inside out for as long as they were bent.
TEST(SoftHand, FoldedFingersAreHeldRightSideOut) {
  for (const double bend : {1.5, 1.75, 2.0, 2.5, -1.5})
    for (const int frames : {1, 30}) {
      std::vector<TrackedHand> way;
      for (int step = 1; step <= frames; ++step) way.push_back(palmDown(0.0, false, bend * step / frames));
      expectHeldRightSideOut(way, std::to_string(bend) + " in " + std::to_string(frames));
    }
}

TEST(SoftHand, FingersAtAnyAnglesAreHeldRightSideOut) {
  for (const int seed : {31, 32, 33, 34, 35, 36, 37, 38}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> angle(-M_PI, M_PI);
    HandPose pose;
    for (FingerAngles& finger : pose.fingers) {
      for (double& flexion : finger.flexion) flexion = angle(random);
      finger.abduction = angle(random);
    }
    expectHeldRightSideOut({forwardKinematics(pose)}, std::to_string(seed));
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

// An impossible hand is changed to a possible one. In an earlier version up to 61 tetrahedra of scrambled
// joints stayed inside out for as long as they were held, and hundreds of a collapsed or a tiny hand, and the
// skin trembled at up to 2 m/s.
TEST(SoftHand, WhatIsNoHandIsHeldRightSideOut) {
  const TrackedHand flat = palmDown(0.0);
  const Vector3d middle = flat.joints[palm].position;
  for (const double size : {1e-3, 0.3, 2.5}) {
    TrackedHand odd = flat;
    for (JointPose& joint : odd.joints) joint.position = middle + size * (joint.position - middle);
    expectHeldRightSideOut({odd}, "size " + std::to_string(size), 0.05);
  }
  for (const int seed : {61, 62, 63, 64, 65})
    for (const double size : {0.004, 0.008, 0.012, 0.02, 0.03}) {
      std::mt19937 random(seed);
      expectHeldRightSideOut({scrambled(flat, size, random)},
                             std::to_string(seed) + ", " + std::to_string(size), 0.05);
    }
}

// Proportions that no hand has, although each bone by itself is possible: in an earlier version up to 31
// tetrahedra stayed inside out between the thumb and the palm. Mirrored hands, as from a tracker that takes
// left for right: up to 13 in the folds into which they are moved.
TEST(SoftHand, StretchedAndMirroredHandsAreHeldRightSideOut) {
  const auto linear = [](TrackedHand hand, const Eigen::Matrix3d& map) {
    const Vector3d middle = hand.joints[palm].position;
    for (JointPose& joint : hand.joints) joint.position = middle + map * (joint.position - middle);
    return hand;
  };
  for (const double bend : {0.0, 0.6, 1.2})
    for (const Vector3d& by : {Vector3d(0.7, 0.9, 1.4),
                               {0.7, 1.0, 1.0},
                               {0.6, 1.3, 0.9},
                               {1.4, 0.8, 0.7},
                               {1.0, 0.6, 1.5},
                               {-1.0, 1.0, 1.0},
                               {1.0, -1.0, 1.0},
                               {1.0, 1.0, -1.0},
                               {-1.0, -1.0, -1.0}})
      expectHeldRightSideOut({linear(palmDown(0.0, false, bend), by.asDiagonal())},
                             std::to_string(bend) + ", " + std::to_string(by.x()) + ' ' +
                                 std::to_string(by.y()) + ' ' + std::to_string(by.z()),
                             0.05);
}

// One finger is elsewhere. It drags the palm, whose pose is found from all fingers, while only the thumb
// stayed in its place. In an earlier version up to 17 tetrahedra stayed inside out between the two.
TEST(SoftHand, AFingerAstrayIsHeldRightSideOut) {
  struct Astray {
    double size;
    Eigen::Quaterniond turn;
    Vector3d by;  // m
  };
  const Eigen::Quaterniond over(-0.1862, -0.5478, -0.4603, 0.6733);
  for (const Astray& astray : {Astray{0.617, over.normalized(), {0.0, 0.0073, -0.0077}},
                               {1.0, Eigen::Quaterniond::Identity(), {0.0, 0.06, 0.0}},
                               {1.0, Eigen::Quaterniond::Identity(), {0.05, 0.0, 0.03}}}) {
    TrackedHand odd = palmDown(0.0);
    const FingerJoints finger = fingers[4];
    const Vector3d root = odd.joints[finger.first].position;
    for (int j = finger.first; j <= finger.tip(); ++j) {
      JointPose& joint = odd.joints[j];
      joint.position = root + astray.by + astray.size * (astray.turn * (joint.position - root));
      joint.orientation = astray.turn * joint.orientation;
    }
    expectHeldRightSideOut({odd}, "by " + std::to_string(astray.by.norm()), 0.05);
  }
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

// Recorded hands, found anew and held. When the nodes of a bone gave way farther than flesh, up to 7
// tetrahedra at the bone of a spread thumb stayed inside out as long.
TEST(SoftHand, RecordedHandsAreHeldRightSideOut) {
  SoftHands hands(spacing);
  int k = 0, held = 0;
  for (const char* name : {"both_hands_low_confidence", "grab", "left_or_right", "three_claps"}) {
    const auto frames = recordedFrames(name);
    if (!frames) GTEST_SKIP() << handRecording(name) << " is not here";
    for (std::size_t i = 0; i < frames->size(); i += 60) {
      for (const TrackedHand& hand : (*frames)[i].hands) {
        hands.update({}, stampOf(k++));
        k = settled(hands, hand, k, 30);
        EXPECT_EQ(hands.hand(hand.side)->inverted(), 0) << name << ' ' << i;
        for (int f = 0; f < finger_count; ++f) EXPECT_EQ(hands.hand(hand.side)->reach(f), 1.0) << name << i;
        ++held;
      }
    }
  }
  EXPECT_GT(held, 20);
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

std::vector<FleshNode> nodesOf(const FleshMesh& mesh, float mobility) {
  std::vector<FleshNode> nodes(mesh.nodes.size() + unused_flesh_nodes, FleshNode::Zero());
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) nodes[n] << mesh.nodes[n].cast<float>(), mobility;
  return nodes;
}

const std::vector<Capsule>& bentFinger() {
  static const std::vector<Capsule> capsules = {{{0, 0, 0}, {0, 0, -0.04}, 0.010, 0.008},
                                                {{0, 0, -0.04}, {0, -0.02, -0.06}, 0.008, 0.0065}};
  return capsules;
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
}  // namespace tactile_clay::hand
