// Latency by stage, for samples with known times.
#include "nodes/stage_latency.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tactile_clay::nodes {
namespace {

ros::Time at(double ms) {
  return ros::Time(1000, 0) + ros::Duration(1e-3 * ms);
}

std::size_t stage(const RigLatency& told, const std::string& name) {
  for (std::size_t k = 0; k < told.stages.size(); ++k)
    if (told.stages[k] == name) return k;
  throw std::runtime_error("no stage " + name);
}

/// A sample that takes 1, 2, 4, 0.5, 0.25 ms and `array` ms from one topic to the next, with one message per
/// topic at most.
void pass(StageLatency& latency, double stamp, double array, bool skin = true) {
  const double stages[] = {1.0, 2.0, 4.0, 0.5, 0.25, array};
  double ms = stamp;
  for (std::size_t k = 0; k < 6; ++k) {
    ms += stages[k];
    if (k != 1 || skin) latency.arrived(k, at(stamp), at(ms));
  }
}

TEST(StageLatency, OfEachStageAndTheWholeWay) {
  StageLatency latency(60.0);
  latency.arrived(5, ros::Time(), at(0.0));  // the array waits for its first sample
  for (int k = 0; k < 100; ++k) pass(latency, 16.0 * k, k < 98 ? 1.0 : 40.0 * (k - 97));
  latency.arrived(5, at(16.0 * 99), at(16.0 * 99 + 500.0));  // told anew
  latency.finish();
  const RigLatency told = latency.message();
  const double medians[] = {1.0, 2.0, 4.0, 0.5, 0.25, 1.0, 8.75};
  for (std::size_t k = 0; k < 7; ++k) {
    EXPECT_EQ(told.samples[k], 100u);
    EXPECT_NEAR(told.p50_ms[k], medians[k], 1e-3) << told.stages[k];
  }
  // 99 of 100 took at most 40 ms in the array.
  EXPECT_NEAR(told.p99_ms[stage(told, "array")], 40.0, 1e-3);
  EXPECT_NEAR(told.longest_ms[stage(told, "array")], 80.0, 1e-3);
  EXPECT_NEAR(told.p99_ms[stage(told, "motion_to_touch")], 47.75, 1e-3);
  const std::uint32_t* const counts = &told.counts[told.bins * stage(told, "motion_to_touch")];
  EXPECT_EQ(counts[8], 98u);
  EXPECT_EQ(counts[47], 1u);
  EXPECT_EQ(counts[told.bins - 1], 1u) << "what is longer";
  EXPECT_EQ(told.lost, 0u);
}

TEST(StageLatency, WithoutSkinItsTimeIsTheClays) {
  StageLatency latency(60.0);
  pass(latency, 0.0, 1.0, false);
  latency.finish();
  const RigLatency told = latency.message();
  EXPECT_EQ(told.samples[stage(told, "hand")], 0u);
  EXPECT_TRUE(std::isnan(told.p50_ms[stage(told, "hand")]));
  EXPECT_NEAR(told.p50_ms[stage(told, "clay")], 6.0, 1e-3);
}

TEST(StageLatency, WhatIsOvertakenIsLost) {
  StageLatency latency(60.0);
  latency.arrived(0, at(0.0), at(1.0));
  latency.arrived(1, at(0.0), at(2.0));
  pass(latency, 16.0, 1.0);
  latency.finish();
  EXPECT_EQ(latency.message().lost, 1u);
  EXPECT_EQ(latency.message().samples[0], 1u);
}

TEST(StageLatency, OnlyTheNewestCount) {
  StageLatency latency(1.0);
  pass(latency, 0.0, 30.0);
  for (int k = 1; k <= 200; ++k) pass(latency, 16.0 * k, 1.0);
  latency.finish();
  EXPECT_EQ(latency.message().samples[0], 63u);  // 0 to 62 times 16 ms ago
  EXPECT_NEAR(latency.message().longest_ms[5], 1.0, 1e-3);
}

TEST(StageLatency, StampsOfARecordingTellNoMotion) {
  StageLatency latency(60.0);
  for (std::size_t k = 0; k < 6; ++k) latency.arrived(k, ros::Time(7, 0), at(static_cast<double>(k)));
  latency.finish();
  const RigLatency told = latency.message();
  EXPECT_EQ(told.samples[stage(told, "motion_to_touch")], 0u);
  EXPECT_EQ(told.samples[stage(told, "tracking")], 0u);
  EXPECT_NEAR(told.p50_ms[stage(told, "array")], 1.0, 1e-3);
}

}  // namespace
}  // namespace tactile_clay::nodes
