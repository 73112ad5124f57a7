#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "leakage.h"

/// Robust contact at random: fists, claps, slams and grabs of any kind leave no clay inside hands or below
/// the table.
namespace tactile_clay::clay::random_leakage_test {
namespace {

/// One of many in a test.
struct OneOfMany : Leakage {
  using Leakage::advance, Leakage::deepest, Leakage::inside, Leakage::touched, Leakage::under;
  explicit OneOfMany(const std::vector<InitialParticle>& particles) : Leakage(particles) {}
  void TestBody() override {}
};

/// The same from starts shaken by 1e-6 of a spacing, so that particles take different ways. In the frame of
/// the fist the palm and the fingers overlap, and some clay has no place to go.
TEST(ShakenOnThePalm, AFistInOneFrameLeavesNoneInside) {
  for (const hand::Side side : {hand::Side::left, hand::Side::right}) {
    for (unsigned seed = 1; seed <= 8; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      std::mt19937 random(seed);
      std::uniform_real_distribution<float> shake(-1e-6f, 1e-6f);
      auto particles = block(4, 4, 4, spacing, {0.0, 0.0, 0.1 + 0.5 * spacing});
      for (InitialParticle& p : particles)
        p.position +=
            static_cast<float>(spacing) * Eigen::Vector3f(shake(random), shake(random), shake(random));
      OneOfMany shaken(particles);
      for (int k = 0; k < 30; ++k) {
        const double bend = k < 20 ? 0.0 : 85 * degree;
        shaken.advance(
            {handAt(side, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX(), 0.1, {0.02, 0.0, 0.0}, bend)});
        EXPECT_EQ(shaken.inside, 0) << "frame " << k << " by " << -shaken.deepest << " m";
      }
    }
  }
}

/// Fists of any kind, around clay that is shaken by 1e-6 of a spacing, so that particles take different ways.
/// In the frame of the fist the fingers and the palm overlap, and leave some clay no room at its place.
TEST(RandomFists, InOneFrameLeaveNoneInside) {
  for (unsigned seed = 61; seed <= 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0.0, 1.0);
    auto particles = block(4, 4, 4, spacing, {0.0, 0.0, 0.1 + 0.5 * spacing});
    for (InitialParticle& p : particles)
      p.position += 1e-6f * static_cast<float>(spacing) *
                    Eigen::Vector3f::NullaryExpr([&] { return static_cast<float>(any(random)); });
    const double bend = (60.0 + 30.0 * any(random)) * degree, thumb = -0.6 + 0.4 * any(random);
    const double along = 0.01 + 0.02 * any(random);
    const hand::Side side = seed % 2 == 0 ? hand::Side::right : hand::Side::left;
    OneOfMany one(particles);
    for (int k = 0; k < 30; ++k) {
      one.advance({handAt(side, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX(), 0.1, {along, 0.0, 0.0},
                          k < 20 ? 0.0 : bend, thumb)});
      EXPECT_EQ(one.inside, 0) << "frame " << k << " by " << -one.deepest << " m";
    }
  }
}

/// Hands of any kind, in any direction and at any height, through a block on the table at 0.5 to 5 m/s.
TEST(RandomHands, ThroughClayLeaveNoneInside) {
  for (unsigned seed = 41; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const auto any = [&random](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    const double speed = any(0.5, 5.0), yaw = any(0.0, 2.0 * M_PI), bend = any(0.0, 70.0) * degree;
    const double thumb = any(-0.6, -0.2), height = any(0.005, 0.04), tilt = any(-1.0, 1.0);
    const Eigen::Vector3d way(std::cos(yaw), std::sin(yaw), 0.0);
    const Eigen::Vector3d beside = any(-0.015, 0.015) * Eigen::Vector3d::UnitZ().cross(way);
    const Eigen::Vector3d fingers =
        Eigen::AngleAxisd(any(0.0, 2.0 * M_PI), Eigen::Vector3d::UnitZ()) * Eigen::Vector3d::UnitX();
    const Eigen::Vector3d palm = Eigen::AngleAxisd(tilt, fingers) * -Eigen::Vector3d::UnitZ();
    const hand::Side side = seed % 2 == 0 ? hand::Side::right : hand::Side::left;
    OneOfMany one(block(8, 8, 8, spacing));
    for (int k = 0; k < 60; ++k) {
      const Eigen::Vector3d at =
          std::min(-0.3 + speed * frame * k, 0.3) * way + beside + height * Eigen::Vector3d::UnitZ();
      one.advance({handAt(side, palm, fingers, at.dot(palm), at, bend, thumb)});
      EXPECT_EQ(one.inside, 0) << "frame " << k << " by " << -one.deepest << " m";
      EXPECT_EQ(one.under, 0) << "frame " << k;
    }
    EXPECT_TRUE(one.touched);
  }
}

/// Plays scenes of a block and hands that move, each by its seed.
template <typename Scene>
void expectNoLeak(const std::vector<unsigned>& seeds, const Scene& scene) {
  for (const unsigned seed : seeds) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const auto any = [&random](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    const int nx = 4 + static_cast<int>(random() % 5), ny = 4 + static_cast<int>(random() % 5);
    OneOfMany one(block(nx, ny, 4 + static_cast<int>(random() % 4), spacing));
    const auto hands = scene(any);
    for (int k = 0; k < 60; ++k) {
      one.advance(hands(k));
      EXPECT_EQ(one.inside, 0) << "frame " << k << " by " << -one.deepest << " m";
      EXPECT_EQ(one.under, 0) << "frame " << k;
    }
    EXPECT_TRUE(one.touched);
  }
}

std::vector<unsigned> seedsTo(unsigned last) {
  std::vector<unsigned> seeds(last);
  std::iota(seeds.begin(), seeds.end(), 1u);
  return seeds;
}

/// Two hands clap a block on the table between them, to 2 to 20 mm, at 0.2 to 3 m/s each. In the scene of
/// seed 87 clay was moved under the table when the search for room did not check the table.
TEST(RandomClaps, LetClayGoSideways) {
  std::vector<unsigned> seeds = seedsTo(20);
  seeds.push_back(87);
  expectNoLeak(seeds, [](const auto& any) {
    const double speed = any(0.2, 3.0), minimum = any(0.001, 0.01), yaw = any(0.0, 2.0 * M_PI);
    const double height = any(0.01, 0.03), bend = any(0.0, 20.0) * degree, thumb = any(-0.6, -0.2);
    const Eigen::Vector3d way(std::cos(yaw), std::sin(yaw), 0.0);
    const Eigen::Vector3d up = Eigen::AngleAxisd(any(0.0, 1.5), way) * Eigen::Vector3d::UnitZ();
    return [=](int k) {
      const double half = std::max(0.15 - speed * frame * k, minimum);
      std::vector<hand::TrackedHand> hands;
      for (const double side : {-1.0, 1.0}) {
        const Eigen::Vector3d at = side * half * way + height * Eigen::Vector3d::UnitZ();
        hands.push_back(handAt(side < 0.0 ? hand::Side::left : hand::Side::right, -side * way,
                               up.cross(way).normalized(), -side * at.dot(way), at, bend, thumb));
      }
      return hands;
    };
  });
}

/// A hand comes down on a block on the table at 0.3 to 5 m/s, to where its fingers are 4 to 12 mm above it,
/// and goes up again.
TEST(RandomSlams, LetClayGoSideways) {
  expectNoLeak(seedsTo(20), [](const auto& any) {
    const double speed = any(0.3, 5.0), minimum = any(0.004, 0.012), along = any(-0.02, 0.02);
    const double bend = any(0.0, 45.0) * degree, thumb = any(-0.6, -0.2);
    const Eigen::Vector3d fingers =
        Eigen::AngleAxisd(any(0.0, 2.0 * M_PI), Eigen::Vector3d::UnitZ()) * Eigen::Vector3d::UnitX();
    const Eigen::Vector3d palm = Eigen::AngleAxisd(any(-0.3, 0.3), fingers) * -Eigen::Vector3d::UnitZ();
    const hand::Side side = any(0.0, 1.0) < 0.5 ? hand::Side::left : hand::Side::right;
    return [=](int k) {
      const double height =
          k > 40 ? minimum + 0.5 * frame * (k - 40) : std::max(0.2 - speed * frame * k, minimum);
      const Eigen::Vector3d at = along * fingers + height * Eigen::Vector3d::UnitZ();
      return std::vector<hand::TrackedHand>{handAt(side, palm, fingers, at.dot(palm), at, bend, thumb)};
    };
  });
}

/// A hand that came down into a block becomes a fist in one frame, opens in another, and closes once more. In
/// the scene of seed 43 clay was moved into the web between two fingers, because bent fingers had bared a web
/// without samples.
TEST(RandomGrabs, LeaveNoneInside) {
  std::vector<unsigned> seeds = seedsTo(20);
  seeds.push_back(43);
  expectNoLeak(seeds, [](const auto& any) {
    const double speed = any(0.1, 1.0), minimum = any(0.01, 0.03), along = any(0.0, 0.03);
    const double bend = any(50.0, 95.0) * degree, thumb = any(-0.6, -0.2);
    const Eigen::Vector3d fingers =
        Eigen::AngleAxisd(any(0.0, 2.0 * M_PI), Eigen::Vector3d::UnitZ()) * Eigen::Vector3d::UnitX();
    const hand::Side side = any(0.0, 1.0) < 0.5 ? hand::Side::left : hand::Side::right;
    const int down = static_cast<int>((0.12 - minimum) / (speed * frame)) % 30 + 3;
    return [=](int k) {
      const double height = std::max(minimum + 0.12 - speed * frame * k, minimum);
      const bool closed = k >= down && (k < down + 15 || k >= down + 22);
      const Eigen::Vector3d at = along * fingers + height * Eigen::Vector3d::UnitZ();
      return std::vector<hand::TrackedHand>{handAt(side, -Eigen::Vector3d::UnitZ(), fingers, -height, at,
                                                   closed     ? bend
                                                   : k < down ? 0.0
                                                              : 0.2,
                                                   thumb)};
    };
  });
}

}  // namespace
}  // namespace tactile_clay::clay::random_leakage_test
