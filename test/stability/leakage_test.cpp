#include "leakage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <tuple>
#include <vector>

#include "hand/soft_hands.h"

/// Robust contact: violent hands leave no clay inside them or below the table, and squeezed clay goes
/// sideways, not through.
namespace tactile_clay::clay::leakage_test {
namespace {

/// Whether a part of the flesh has its surface around x: its solid angle there (van Oosterom & Strackee
/// 1983).
bool insideFlesh(const hand::SoftHand& soft, const hand::SoftHandTemplate& anatomy,
                 const Eigen::Vector3d& x) {
  for (std::size_t part = 0; part + 1 < anatomy.part_begin.size(); ++part) {
    double angle = 0.0;
    for (int t = anatomy.part_begin[part]; t < anatomy.part_begin[part + 1]; ++t) {
      const auto at = [&](int corner) {
        return Eigen::Vector3d(soft.node(anatomy.mesh.triangles[t][corner]).cast<double>() - x);
      };
      const Eigen::Vector3d a = at(0), b = at(1), c = at(2);
      const double na = a.norm(), nb = b.norm(), nc = c.norm();
      angle +=
          2.0 * std::atan2(a.dot(b.cross(c)), na * nb * nc + a.dot(b) * nc + b.dot(c) * na + c.dot(a) * nb);
    }
    if (std::abs(angle) > 2.0 * M_PI) return true;
  }
  return false;
}

class HandThroughClay : public Leakage, public ::testing::WithParamInterface<double> {};
TEST_P(HandThroughClay, LeavesNoneInside) {
  const double speed = GetParam();
  for (int k = 0; k < 60; ++k) {
    const double x = std::min(-0.35 + speed * frame * k, 0.35);
    advance({handAt(hand::Side::right, -Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX(), -0.02,
                    {x, 0.0, 0.0})});
    ASSERT_EQ(under, 0) << "frame " << k;
    ASSERT_EQ(inside, 0) << "frame " << k << " by " << -deepest << " m";
  }
  EXPECT_TRUE(touched);
}
INSTANTIATE_TEST_SUITE_P(MetresPerSecond, HandThroughClay, ::testing::Values(0.5, 1.0, 2.0, 5.0));

/// The hand closes from one frame to the next, with clay on its palm.
class OnThePalm : public Leakage, public ::testing::WithParamInterface<std::tuple<hand::Side, double>> {
 protected:
  OnThePalm() : Leakage(block(4, 4, 4, spacing, {0.0, 0.0, 0.1 + 0.5 * spacing})) {}

  static hand::TrackedHand bent(double bend) {
    const auto [side, thumb] = GetParam();
    return handAt(side, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX(), 0.1, {0.02, 0.0, 0.0}, bend,
                  thumb);
  }
};

TEST_P(OnThePalm, AFistInOneFrameLeavesNoneInside) {
  for (int k = 0; k < 20; ++k) advance({bent(0.0)});
  EXPECT_TRUE(touched);
  for (int k = 0; k < 40; ++k) {
    advance({bent(85 * degree)});
    EXPECT_EQ(inside, 0) << "frame " << k << " by " << -deepest << " m";
    EXPECT_EQ(under, 0) << "frame " << k;
  }
}

/// The place of the soft hand's flesh is that of its triangles, not that of the tracked hand. Fingers that
/// press on each other through clay may snap over a particle; it is out again within the 0.2 s that an
/// inversion may last.
TEST_P(OnThePalm, ASoftFistInOneFrameKeepsNoneInside) {
  const hand::SoftHandParameters parameters;
  hand::SoftHands soft(spacing, parameters);
  const hand::SoftHandTemplate anatomy =
      hand::makeSoftHandTemplate(std::get<0>(GetParam()), parameters.finger_cell, parameters.palm_cell);
  const int maximum = static_cast<int>(std::lround(0.2 / frame));
  std::vector<int> within(clay.particles().size(), 0);  // frames on end
  for (int k = 0; k < 60; ++k) {
    const auto stamp = std::chrono::nanoseconds(std::llround(1e9 * (clay.time() + frame)));
    const Skin skin = soft.update({bent(k < 20 ? 0.0 : 85 * degree)}, stamp);
    clay.advance(skin, {ground()}, frame);
    soft.react(stamp, clay.skinForces());
    touched = touched || !clay.skinForces().empty();
    if (k < 20) continue;
    for (std::size_t i = 0; i < clay.particles().size(); ++i) {
      const bool engulfed = insideFlesh(*soft.hand(std::get<0>(GetParam())), anatomy,
                                        clay.particles().position.at(i).cast<double>());
      within[i] = engulfed ? within[i] + 1 : 0;
      EXPECT_LT(within[i], maximum) << "particle " << i << " frame " << k;
    }
  }
  EXPECT_TRUE(touched);
  const hand::SoftHand& hand = *soft.hand(std::get<0>(GetParam()));
  for (const hand::Joint joint : {hand::index_intermediate, hand::middle_metacarpal})
    EXPECT_TRUE(insideFlesh(hand, anatomy, hand.joints()[joint]));
}

INSTANTIATE_TEST_SUITE_P(SidesAndThumbs, OnThePalm,
                         ::testing::Combine(::testing::Values(hand::Side::left, hand::Side::right),
                                            ::testing::Values(-0.3, -0.6)));

TEST_F(Leakage, ClayBetweenTwoHandsGoesSideways) {
  double half = 0.0;
  for (int k = 0; k < 60; ++k) {
    half = std::max(0.03 - 0.1 * frame * k, 0.008);
    advance({handAt(hand::Side::left, -Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX(), -half,
                    {0.0, 0.0, 0.05}),
             handAt(hand::Side::right, Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX(), -half,
                    {0.0, 0.0, 0.05})});
  }
  EXPECT_TRUE(touched);
  EXPECT_EQ(inside, 0);
  EXPECT_EQ(under, 0);
  int through = 0;
  for (std::size_t i = 0; i < clay.particles().size(); ++i) {
    const Eigen::Vector3f x = clay.particles().position.at(i);
    through +=
        std::abs(x.y()) > half + 0.02 && std::abs(x.x()) < 0.04 && x.z() > 0.03 && x.z() < 0.08 ? 1 : 0;
  }
  EXPECT_EQ(through, 0);
  const auto [back, front] = extent(clay.particles(), Eigen::Vector3d::UnitX());
  EXPECT_GT(front - back, 0.045) << "of a block of 0.04 m";
}

TEST_F(Leakage, ClayBetweenHandAndTableGoesSideways) {
  for (int k = 0; k < 60; ++k) {
    const double height = std::max(0.05 - 0.1 * frame * k, 0.008);
    advance({handAt(hand::Side::right, -Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX(), -height,
                    {0.0, 0.0, 0.0})});
  }
  EXPECT_TRUE(touched);
  EXPECT_EQ(inside, 0);
  EXPECT_EQ(under, 0);
  const auto [low, high] = extent(clay.particles(), Eigen::Vector3d::UnitX());
  EXPECT_GT(high - low, 0.06) << "of a block of 0.04 m";
}

}  // namespace
}  // namespace tactile_clay::clay::leakage_test
