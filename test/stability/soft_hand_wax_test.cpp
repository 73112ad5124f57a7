// A soft hand pressed into clay and hard wax: the force, how it buzzes, and flesh that is inside out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include "hand/soft_hands.h"
#include "support/pressed_hand.h"
#include "support/setups.h"
#include "watched_hand.h"

namespace tactile_clay::hand::soft_hand_wax_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

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

// Two seconds after a hand came to this depth in hard wax, the force on it does not buzz, and no flesh stays
// inside out. Later a finger may slide to another place, so one of the five seconds may be worse: in 30 runs
// this happened in three of the 180 seconds. In that second, too, flesh is right side out again after a sixth
// of a second.
void expectNoBuzzInWax(bool pointing, double depth, double aside) {
  constexpr int rest = 120, second = 60;
  WaxPress press(pointing, aside);
  press.approach(-depth);
  for (int k = 0; k < rest; ++k) press.frame(-depth);
  std::vector<double> each;
  std::vector<int> inside_out;  // frames on end in each second
  for (int s = 0; s < 5; ++s) {
    std::vector<double> force;
    InsideOut flesh;
    for (int k = 0; k < second; ++k) {
      press.frame(-depth);
      flesh.see(press.soft());
      force.push_back(press.soft().force().norm());
      ASSERT_GT(force.back(), 1.0);
    }
    each.push_back(buzz(force));
    inside_out.push_back(flesh.longest);
  }
  std::sort(each.begin(), each.end());
  std::sort(inside_out.begin(), inside_out.end());
  std::printf("  %s, %.0f mm in wax: above 20 Hz %.2f %% of the force, once %.2f %%\n",
              pointing ? "finger" : "palm", 1e3 * depth, 1e2 * each[3], 1e2 * each[4]);
  EXPECT_LT(each[3], 0.05) << depth << ' ' << aside;
  EXPECT_LE(inside_out[3], 3) << depth << ' ' << aside;
  EXPECT_LE(inside_out[4], 10) << depth << ' ' << aside;
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

}  // namespace
}  // namespace tactile_clay::hand::soft_hand_wax_test
