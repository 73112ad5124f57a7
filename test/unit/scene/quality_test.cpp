// What `quality:=auto` chooses among, what it chooses, and when it gives up accuracy.
#include "scene/quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clay/late_watch.h"
#include "scene/measured_frames.h"
#include "scene/robot_model.h"
#include "support/error_of.h"

namespace tactile_clay::scene::quality_test {
namespace {

const std::string share = TACTILE_CLAY_SHARE;

TEST(Qualities, EachIsMoreAccurateAndCostsMoreThanTheOneBefore) {
  const std::vector<Quality> steady = steadyQualities(loadQualities(share));
  ASSERT_GE(steady.size(), 4u);
  for (std::size_t k = 1; k < steady.size(); ++k) {
    const Quality &coarse = steady[k - 1], &fine = steady[k];
    EXPECT_GT(fine.budget.substeps * fine.budget.iterations,
              coarse.budget.substeps * coarse.budget.iterations)
        << fine.name;
    EXPECT_LT(fine.kneading.force, coarse.kneading.force) << fine.name;
    EXPECT_LT(fine.wheel.force, coarse.wheel.force) << fine.name;
    EXPECT_LT(fine.kneading.displacement, coarse.kneading.displacement) << fine.name;
    EXPECT_LT(fine.wheel.displacement, coarse.wheel.displacement) << fine.name;
  }
  EXPECT_EQ(loadQualities(share).size(), steady.size() + 1) << "the paper's own scheme is no choice";
}

TEST(Qualities, TheMostAccurateThatHoldsIsTaken) {
  EXPECT_EQ(mostAccurate({2.0, 4.0, 6.0, 15.0}, 5.0), 1u);
  EXPECT_EQ(mostAccurate({2.0, 4.0, 6.0, 15.0}, 6.0), 2u) << "a target is held where it is met";
  EXPECT_EQ(mostAccurate({2.0, 4.0, 6.0, 15.0}, 100.0), 3u);
  EXPECT_EQ(mostAccurate({2.0, 4.0, 6.0, 15.0}, 1.0), 0u) << "none holds: the coarsest";
  EXPECT_EQ(mostAccurate({2.0, 4.0}, 5.0), 1u) << "what was not measured does not hold";
  EXPECT_EQ(mostAccurate({2.0, 5.5, 4.9}, 5.0), 2u) << "a frame of a coarser one that was late by chance";
  EXPECT_EQ(mostAccurate({}, 5.0), 0u);
}

TEST(Qualities, WhatCostsTooMuchGivesWayToTheNextCoarser) {
  const std::vector<Quality> steady = steadyQualities(loadQualities(share));
  const auto below = [&](int substeps, int iterations) {
    const Quality* coarser = coarserThan({substeps, iterations}, steady);
    return coarser ? coarser->name : "";
  };
  EXPECT_EQ(below(12, 8), "balanced");
  EXPECT_EQ(below(8, 16), "balanced") << "12 x 8 takes as long";
  EXPECT_EQ(below(4, 8), "fast");
  EXPECT_EQ(below(4, 6), "fast");
  EXPECT_EQ(below(3, 8), "draft");
  EXPECT_EQ(below(2, 8), "");
  EXPECT_EQ(below(6, 12), "balanced") << "a budget of one's own";
}

TEST(Qualities, WhatToExpectIsToldInOneLine) {
  Quality quality;
  quality.kneading = {0.065, 0.26};
  quality.wheel = {0.117, 1.78};
  EXPECT_EQ(expectation(quality),
            "errors to expect when kneading: force on hands 6.5 %, shape 0.26 spacings; on a wheel: 11.7 %, "
            "1.8 spacings");
}

TEST(Qualities, OnlyALiveRigWithoutItsOwnBudgetIsFitted) {
  const std::vector<Quality> all = loadQualities(share);
  const auto complaint = [&](QualityWish wish) { return errorOf([&] { requireQuality(wish, all); }); };
  QualityWish wish;
  EXPECT_EQ(complaint(wish), "");
  wish.lockstep = true;
  EXPECT_EQ(complaint(wish), "");
  wish.quality = automatic;
  EXPECT_EQ(complaint(wish),
            "quality 'auto' fits the quality to the computer: expected one of the presets and target_ms 0 in "
            "lockstep, where nothing depends on the clock");
  wish.quality = "fast";
  wish.target_ms = 5.0;
  EXPECT_NE(complaint(wish).find("target_ms above 0 fits"), std::string::npos);
  wish.lockstep = false;
  EXPECT_EQ(complaint(wish), "");
  wish.quality = automatic;
  EXPECT_EQ(complaint(wish), "");
  wish.substeps = 3;
  EXPECT_NE(complaint(wish).find("expected no substeps and iterations"), std::string::npos);
  wish.substeps = 0;
  wish.solver = "paper";
  EXPECT_NE(complaint(wish).find("expected the solver minimise"), std::string::npos);
  wish.solver = "";
  wish.quality = "paper";
  EXPECT_NE(complaint(wish).find("expected a preset of the solver minimise"), std::string::npos);
  wish.target_ms = 0.0;
  EXPECT_EQ(complaint(wish), "");
  wish.quality = "best";
  EXPECT_NE(complaint(wish).find("quality 'best' not found, expected one of: draft, "), std::string::npos);
}

TEST(Qualities, AreMeasuredOnTheSceneFromTheCoarsestOn) {
  const Scene scene = loadScene("press", share, 0.01);
  const Solids solids(loadRobotModel(scene.urdf), scene.motions);
  const std::vector<Quality> steady = steadyQualities(loadQualities(share));
  const std::vector<double> all = measuredFrames(scene, solids, steady, 1e9);
  ASSERT_EQ(all.size(), steady.size());
  for (const double ms : all) EXPECT_GT(ms, 0.0);
  EXPECT_EQ(measuredFrames(scene, solids, steady, 0.0).size(), 1u) << "the first takes longer than that";

  const Skin before = pressingBalls(scene, 0.0), after = pressingBalls(scene, 0.1);
  ASSERT_GT(before.size(), 0u);
  float low_before = 1.0f, low_after = 1.0f, top = 0.0f;
  for (std::size_t g = 0; g < before.size(); ++g) {
    EXPECT_NEAR(before.normal[g].norm(), 1.0f, 1e-5f);
    low_before = std::min(low_before, before.position[g].z());
    low_after = std::min(low_after, after.position[g].z());
  }
  for (const clay::InitialParticle& particle : scene.particles) top = std::max(top, particle.position.z());
  EXPECT_NEAR(low_before, top, 1e-3f) << "they touch the clay at first";
  EXPECT_NEAR(low_before - low_after, 0.015f, 1e-5f);
}

TEST(LateWatch, OneBadSecondIsNoReason) {
  constexpr double frame = 1.0 / 60.0;
  clay::LateWatch watch(0.005, frame);
  const auto seconds = [&](double time, double computing) {
    bool late = false;
    for (int k = 0; k < static_cast<int>(std::lround(time / frame)); ++k)
      late |= watch.late(frame, frame, computing);
    return late;
  };
  EXPECT_FALSE(seconds(6.0, 0.004));
  EXPECT_FALSE(seconds(0.9, 0.030)) << "fewer than half of the frames of two seconds";
  EXPECT_FALSE(seconds(1.2, 0.004));
  EXPECT_TRUE(seconds(4.1, 0.006));
}

TEST(LateWatch, FramesOfAnyLengthCountByWhatAPeriodCosts) {
  constexpr double frame = 1.0 / 60.0;
  const auto late = [&](double simulated, double computing) {
    clay::LateWatch watch(0.005, frame);
    bool once = false;
    for (int k = 0; k < 200; ++k) once |= watch.late(frame, simulated, computing);
    return once;
  };
  EXPECT_FALSE(late(1.5 * frame, 0.007));
  EXPECT_TRUE(late(1.5 * frame, 0.008));
  EXPECT_TRUE(late(0.5 * frame, 0.003));
  EXPECT_FALSE(late(0.0, 1.0)) << "nothing was simulated";
}

}  // namespace
}  // namespace tactile_clay::scene::quality_test
