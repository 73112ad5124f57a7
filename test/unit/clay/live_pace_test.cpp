#include "clay/live_pace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tactile_clay::clay::live_pace_test {
namespace {

constexpr double period = 1.0 / 60.0, step = period / 4.0;

TEST(LivePace, FramesOfAnUnevenClockAreEven) {
  LivePace pace(period, step);
  for (int k = 0; k < 600; ++k) {
    const double duration = pace.next(period * (k % 3 == 0 ? 1.3 : 0.85));
    pace.took(duration, 0.6 * duration);
    EXPECT_NEAR(duration, period, 1e-12) << k;
  }
}

TEST(LivePace, StepsAreWhole) {
  for (const double interval : {0.3, 0.7, 1.0, 1.4}) {
    LivePace pace(period, step);
    for (int k = 0; k < 100; ++k) {
      const double steps = pace.next(interval * period) / step;
      EXPECT_NEAR(steps, std::round(steps), 1e-9);
      pace.took(steps * step, 0.5 * steps * step);
    }
  }
}

TEST(LivePace, FollowsAClockFasterThanItsSteps) {
  constexpr double interval = step / 8.0;
  LivePace pace(interval, step);
  double simulated = 0.0;
  for (int k = 0; k < 4000; ++k) {
    const double duration = pace.next(interval);
    simulated += duration;
    pace.took(duration, 0.6 * duration);
    EXPECT_LE(duration, step);
  }
  EXPECT_NEAR(simulated, 4000 * interval, 2.0 * step);
  EXPECT_EQ(pace.takeDropped(), 0.0);
}

TEST(LivePace, CatchesUpWithStepsOfAnySize) {
  for (const double length : {period, step, period / 16.0}) {
    LivePace pace(period, length);
    pace.next(5.0 * period);  // a hiccup
    double simulated = 0.0;
    for (int k = 0; k < 24; ++k) {
      const double duration = pace.next(period);
      pace.took(duration, 0.7 * duration);
      simulated += duration;
    }
    EXPECT_NEAR(simulated, 28.0 * period, 1.5 * std::max(length, step)) << length;
  }
}

/// Frames that take nearly their time, such as those of the wheel on a slow host, still make up for a hiccup.
TEST(LivePace, CatchesUpWithLittleRoom) {
  constexpr double cost = 0.85;  // of what is simulated
  LivePace pace(period, step);
  double elapsed = 5.0 * period, simulated = 0.0, interval = elapsed;
  for (int k = 0; k < 60; ++k) {
    const double duration = pace.next(interval);
    pace.took(duration, cost * duration);
    simulated += duration;
    interval = std::max(period, cost * duration);
    elapsed += interval;
  }
  EXPECT_NEAR(simulated, elapsed - interval, 1.5 * step);
  EXPECT_EQ(pace.takeDropped(), 0.0);
}

TEST(LivePace, FollowsAnUnevenClock) {
  LivePace pace(period, step);
  double elapsed = 0.0, simulated = 0.0;
  for (int k = 0; k < 600; ++k) {
    const double interval = period * (k % 3 == 0 ? 1.3 : 0.85);
    elapsed += interval;
    const double duration = pace.next(interval);
    simulated += duration;
    pace.took(duration, 0.6 * duration);
    EXPECT_LE(duration, 1.5 * period);
  }
  EXPECT_NEAR(simulated, elapsed, 1.5 * step);
  EXPECT_EQ(pace.takeDropped(), 0.0);
}

TEST(LivePace, FollowsATrackerThatIsSlowerOrFasterThanItsRate) {
  for (const double rate : {25.0, 58.0, 62.0, 120.0}) {
    LivePace pace(period, step);
    double simulated = 0.0;
    for (int k = 0; k < 600; ++k) {
      // If no skin comes for 1.5 periods, a frame is made without it.
      double left = 1.0 / rate;
      while (left > 1e-9) {
        const double interval = std::min(left, 1.5 * period);
        const double duration = pace.next(interval);
        pace.took(duration, 0.6 * duration);
        simulated += duration;
        left -= interval;
      }
    }
    EXPECT_NEAR(simulated, 600.0 / rate, 0.5 * period) << rate << " Hz";
    EXPECT_EQ(pace.takeDropped(), 0.0) << rate << " Hz";
  }
}

TEST(LivePace, FramesStayShortWhereComputingIsSlowAndNoTimeIsLostToASlowSecond) {
  LivePace pace(period, step);
  double elapsed = 0.0, simulated = 0.0;
  for (int k = 0; k < 120; ++k) {
    const bool slow = k >= 30 && k < 90;
    const double cost = slow ? 1.05 : 0.6;  // of what is simulated
    const double interval = slow ? 1.05 * period : period;
    elapsed += interval;
    const double duration = pace.next(interval);
    simulated += duration;
    pace.took(duration, cost * duration);
    if (slow && k > 30) {
      EXPECT_LE(duration, period * 1.0000001) << k;
    }
  }
  EXPECT_NEAR(simulated, elapsed, 1.5 * step);  // as near as whole steps are held
  EXPECT_EQ(pace.takeDropped(), 0.0);
}

TEST(LivePace, WhatCannotBeSimulatedIsDroppedAndTold) {
  LivePace pace(period, step);
  double elapsed = 0.0, simulated = 0.0, interval = period;
  for (int k = 0; k < 100; ++k) {
    elapsed += interval;
    const double duration = pace.next(interval);
    simulated += duration;
    interval = 3.0 * duration;
    pace.took(duration, interval);
    EXPECT_LE(duration, period * 1.0000001);
  }
  EXPECT_NEAR(pace.takeDropped(), elapsed - simulated, 0.1 + 1e-9);
  EXPECT_EQ(pace.takeDropped(), 0.0);
}

}  // namespace
}  // namespace tactile_clay::clay::live_pace_test
