#include <cstdio>
#include <limits>

#include "watch.h"

/// Violent hands, impossible starts, large and small amounts of clay, long rests.
namespace tactile_clay::clay::situations_test {
namespace {

constexpr double spacing = 0.005;

Trial standing(int edge = 8) {
  Trial t;
  t.config.threads = 2;
  t.particles = block(edge, edge, edge, spacing);
  return t;
}

TEST(Start, AllParticlesAtOnePoint) {
  Trial t = standing(4);
  for (InitialParticle& p : t.particles) p.position = Eigen::Vector3f(0.0f, 0.0f, 0.02f);
  watch(t);
}

TEST(Start, CoincidentPairs) {
  Trial t = standing(4);
  const auto twins = t.particles;
  t.particles.insert(t.particles.end(), twins.begin(), twins.end());
  watch(t);
}

TEST(Start, HalfInsideTheTable) {
  Trial t = standing();
  t.particles = block(8, 8, 8, spacing, {0.0, 0.0, -0.02});
  t.overlap = 0.02;
  watch(t);
  Clay clay(t.config, t.materials, t.particles);
  for (int k = 0; k < 60; ++k) clay.advance({}, t.solids(0.0), t.config.frame);
  EXPECT_GE(extent(clay.particles(), Eigen::Vector3d::UnitZ()).first, 0.5 * spacing - 1e-5);
}

TEST(Start, AtTheWallsOfTheWorld) {
  Trial t = standing(5);
  t.config.world = 0.02;
  for (InitialParticle& p : t.particles) p.velocity = {3.0f, -2.0f, 5.0f};
  watch(t);
}

TEST(Amount, Zero) {
  Trial t = standing();
  t.particles.clear();
  t.samples = [](double) { return sampleBall(Eigen::Vector3d::Zero(), 0.02, 0.005); };
  watch(t);
}

TEST(Amount, One) {
  Trial t = standing(1);
  t.particles[0].position.z() = 0.01f;
  t.samples = [](double) { return sampleBall({0.0, 0.0, 0.03}, 0.02, 0.005); };
  watch(t);
}

TEST(Amount, TwoHundredThousand) {
  Trial t = standing();
  t.config.world = 2.0;
  t.config.budget = {1, 4};
  t.config.frame = 1.0 / 240.0;
  t.particles = block(100, 100, 20, spacing);
  t.frames = 3;
  watch(t);
}

/// 10^5 steps of clay that never sleeps: no drift, no creep, no buzz.
TEST(Rest, Long) {
  Trial t = standing(4);
  t.config.threads = 1;
  t.config.sleeping = false;
  Clay clay(t.config, t.materials, t.particles);
  for (int k = 0; k < 60; ++k) clay.advance({}, t.solids(0.0), t.config.frame);
  const Eigen::Vector3d start = centreOfMass(clay.particles());
  const auto before = clay.particles().position;
  while (clay.statistics().step < 25000) clay.advance({}, t.solids(0.0), t.config.frame);
  ASSERT_EQ(clay.statistics().awake, t.particles.size());
  const double drift = (centreOfMass(clay.particles()) - start).norm();
  EXPECT_LT(drift, 1e-5);
  float farthest = 0.0f;
  for (std::size_t i = 0; i < before.size(); ++i)
    farthest = std::max(farthest, (clay.particles().position.at(i) - before.at(i)).norm());
  EXPECT_LT(farthest, 1e-4f);
  EXPECT_LT(meanSpeed(clay.particles()), 1e-5);
  std::printf("10^5 steps: the centre drifted by %.2g m, one particle by %.2g m\n", drift, farthest);
}

TEST(Hand, ThroughTheClayAt20MetresPerSecond) {
  Trial t = standing();
  t.collider_speed = 20.0;
  t.samples = [](double time) {
    return sampleBall({-0.5 + 20.0 * time, 0.0, 0.03}, 0.03, 0.004, {20.0, 0.0, 0.0});
  };
  watch(t);
}

/// The same, without velocities in the message: the hand jumps.
TEST(Hand, JumpsThroughTheClay) {
  Trial t = standing();
  t.overlap = 0.06;
  t.samples = [](double time) { return sampleBall({-0.5 + 5.0 * time, 0.0, 0.03}, 0.03, 0.004); };
  watch(t);
}

TEST(Hand, AppearsInsideTheClay) {
  Trial t = standing();
  t.overlap = 0.015;
  t.samples = [](double time) { return time < 0.2 ? Skin() : sampleBall({0.0, 0.0, 0.02}, 0.015, 0.004); };
  watch(t);
}

TEST(Hand, FistClosesInOneFrame) {
  Trial t = standing();
  t.collider_speed = 0.03 * 60.0;
  t.samples = [frame =
                   t.config.frame](double time) {  // four fingers come from 60 mm to 30 mm about the middle
    const int k = static_cast<int>(std::lround(time / frame));
    const double out = k < 10 ? 0.06 : 0.03, speed = k == 10 ? 0.03 / frame : 0.0;
    Skin hand;
    for (int f = 0; f < 4; ++f) {
      const Eigen::Vector3d side(std::cos(0.5 * M_PI * f), std::sin(0.5 * M_PI * f), 0.0);
      append(hand, sampleBall(out * side + Eigen::Vector3d(0.0, 0.0, 0.02), 0.015, 0.004, -speed * side));
    }
    return hand;
  };
  watch(t);
}

TEST(Hand, TwoPalmsSqueezeABlockFlat) {
  Trial t = standing(6);
  t.config.gravity.setZero();
  t.solids = [](double) { return std::vector<Solid>(); };
  t.materials[0].yield_strain = 0.05;
  t.collider_speed = 0.05;
  t.squeezes = true;
  t.samples = [](double time) {
    const double x = std::max(0.016 - 0.05 * time, 0.002), speed = x > 0.002 ? 0.05 : 0.0;
    Skin palms = samplePlane({-x, 0.0, 0.015}, Eigen::Vector3d::UnitX(), 0.06, 0.004, {speed, 0.0, 0.0});
    append(palms, samplePlane({x, 0.0, 0.015}, -Eigen::Vector3d::UnitX(), 0.06, 0.004, {-speed, 0.0, 0.0}));
    return palms;
  };
  watch(t);
}

TEST(Hand, PressesABlockFlatOnTheTable) {
  Trial t = standing(6);
  t.materials[0].yield_strain = 0.05;
  t.collider_speed = 0.1;
  t.squeezes = true;
  t.samples = [](double time) {
    const double z = std::max(0.032 - 0.1 * time, 0.006);
    return samplePlane({0.0, 0.0, z}, -Eigen::Vector3d::UnitZ(), 0.08, 0.004,
                       {0.0, 0.0, z > 0.006 ? -0.1 : 0.0});
  };
  watch(t);
  Clay clay(t.config, t.materials, t.particles);
  for (int k = 1; k <= 40; ++k) clay.advance(t.samples(k * t.config.frame), t.solids(0.0), t.config.frame);
  EXPECT_GT(extent(clay.particles(), Eigen::Vector3d::UnitZ()).first, 0.4 * spacing) << "through the table";
}

class Wheel : public ::testing::TestWithParam<double> {};
TEST_P(Wheel, Rpm) {
  Trial t = standing(6);
  t.config.world = 0.3;
  const double rate = GetParam() * 2.0 * M_PI / 60.0;
  t.collider_speed = rate * 0.05;
  t.solids = [rate](double time) {
    Solid wheel;
    wheel.shape = Solid::Shape::cylinder;
    wheel.size = {0.05, 0.01, 0.0};
    wheel.pose =
        Eigen::Translation3d(0.0, 0.0, -0.01) * Eigen::AngleAxisd(rate * time, Eigen::Vector3d::UnitZ());
    wheel.angular_velocity = {0.0, 0.0, rate};
    return std::vector<Solid>{wheel};
  };
  watch(t);
}
INSTANTIATE_TEST_SUITE_P(At, Wheel, ::testing::Values(0.0, 60.0, 600.0, 3000.0),
                         [](const ::testing::TestParamInfo<double>& tested) {
                           return std::to_string(std::lround(tested.param));
                         });

TEST(Hand, OfRottenNumbers) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const float tiny = std::numeric_limits<float>::denorm_min(), huge = std::numeric_limits<float>::max();
  const std::vector<float> rotten{nan, inf, -inf, tiny, -tiny, huge, -huge, 1e20f, 0.0f};
  Trial t = standing(5);
  t.frames = 30;
  t.collider_speed = 50.0 * std::sqrt(3.0);  // a finite velocity below 50 m/s an axis is believed
  t.overlap = 0.02;
  t.samples = [&rotten, nth = std::size_t{0}](double) mutable {
    Skin hand = sampleBall({0.0, 0.0, 0.035}, 0.015, 0.004);
    for (std::size_t g = 0; g < hand.size(); ++g, ++nth) {
      const int axis = static_cast<int>(nth % 3);
      if (nth % 5 == 1) hand.position[g][axis] = rotten[nth % rotten.size()];
      if (nth % 5 == 2) hand.normal[g][axis] = rotten[nth % rotten.size()];
      if (nth % 5 == 3) hand.velocity[g][axis] = rotten[nth % rotten.size()];
      if (nth % 7 == 4) hand.normal[g].setZero();
      if (nth % 11 == 5) hand.normal[g] *= 1e-20f;
    }
    return hand;
  };
  watch(t);
}

}  // namespace
}  // namespace tactile_clay::clay::situations_test
