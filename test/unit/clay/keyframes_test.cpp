#include "clay/keyframes.h"

#include <gtest/gtest.h>

#include <cstring>

#include "clay/clay.h"
#include "support/error_of.h"
#include "support/setups.h"

namespace tactile_clay::clay::keyframes_test {
namespace {

constexpr double spacing = 0.005, frame = 1.0 / 60.0;

/// The result of a frame: everything that is seen of the clay, and the forces.
struct Frame {
  VectorField position, velocity;
  std::vector<float> density_ratio;
  std::vector<SkinForce> forces;
};

bool sameBits(const Frame& a, const Frame& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && (x.size() == 0 || std::memcmp(&x[0], &y[0], x.size() * sizeof(x[0])) == 0);
  };
  bool forces = a.forces.size() == b.forces.size();
  for (std::size_t k = 0; forces && k < a.forces.size(); ++k)
    forces = a.forces[k].index == b.forces[k].index && a.forces[k].force == b.forces[k].force;
  return forces && same(a.position, b.position) && same(a.velocity, b.velocity) &&
         same(a.density_ratio, b.density_ratio);
}

/// A block that comes to rest and sleeps, and from frame 100 on a finger that wakes and dents it.
Frame advance(Clay& clay, int k) {
  const Eigen::Vector3d velocity(0.0, 0.0, k < 100 ? 0.0 : -0.05);
  const double height = k < 100 ? 0.08 : 0.045 - 0.05 * (k - 99) * frame;
  clay.advance(samplePlane({0.0, 0.0, height}, -Eigen::Vector3d::UnitZ(), 0.006, 0.003, velocity),
               {ground(0.2)}, frame);
  return {clay.particles().position, clay.particles().velocity, clay.particles().density_ratio,
          clay.skinForces()};
}

Clay start() {
  ClayConfig config;
  config.spacing = spacing;
  config.threads = 1;
  return Clay(config, {Material()}, block(6, 6, 6, spacing));
}

TEST(Keyframes, WhatComesAfterAStepBackIsTheSameToTheBit) {
  Clay clay = start();
  Keyframes keyframes({});
  std::vector<Frame> frames;
  keyframes.pass(0.0);
  keyframes.keep(clay.sculpture(), 0);
  for (int k = 0; k < 150; ++k) {
    frames.push_back(advance(clay, k));
    if (keyframes.pass(frame)) keyframes.keep(clay.sculpture(), 0);
  }
  EXPECT_EQ(keyframes.size(), 3u);
  EXPECT_GT(frames.back().forces.size(), 0u);
  double went_back = 0.0;
  // Into the press, before it while the clay slept, and to the start.
  for (const auto& [seconds, first] : {std::pair(0.4, 120), {1.0, 60}, {0.5, 0}}) {
    const Keyframes::State& state = keyframes.back(seconds, went_back);
    EXPECT_GE(went_back, seconds - 1e-6);
    EXPECT_LT(went_back, seconds + 1.0);
    clay.restore(state.clay);
    for (int k = first; k < first + 30; ++k)
      ASSERT_TRUE(sameBits(advance(clay, k), frames[static_cast<std::size_t>(k)]))
          << seconds << " s, frame " << k;
  }
  EXPECT_EQ(keyframes.size(), 1u) << "what was undone is forgotten";
}

TEST(Keyframes, TheirMemoryIsBounded) {
  Clay clay = start();
  Keyframes by_time({5.0, 1u << 30}), by_memory({1e6, 0}), off({0.0, 1u << 30});
  std::size_t one = 0;
  for (int k = 0; k <= 20; ++k) {
    for (Keyframes* keyframes : {&by_time, &by_memory, &off}) {
      const bool due = keyframes->pass(k == 0 ? 0.0 : 1.0);
      EXPECT_EQ(due, keyframes != &off);
      keyframes->keep(clay.sculpture(), 0);
    }
    if (k == 0) one = by_time.bytes();
  }
  EXPECT_EQ(by_time.size(), 6u) << "0 to 5 s old";
  EXPECT_EQ(by_time.bytes(), 6u * one);
  EXPECT_EQ(by_memory.size(), 1u);
  EXPECT_EQ(by_memory.bytes(), one);
  EXPECT_GT(one, clay.particles().size() * 2u * sizeof(Eigen::Vector3f));
  double went_back = 0.0;
  EXPECT_EQ(errorOf([&] { by_time.back(7.0, went_back); }),
            "7.0 s back: expected at most 5.0 s, the age of the oldest state that is kept");
  EXPECT_NE(errorOf([&] { by_time.back(-1.0, went_back); }), "");
  EXPECT_NE(errorOf([&] { off.back(0.0, went_back); }), "");
  by_time.back(5.0, went_back);
  EXPECT_EQ(went_back, 5.0);
  EXPECT_EQ(by_time.size(), 1u);
}

}  // namespace
}  // namespace tactile_clay::clay::keyframes_test
