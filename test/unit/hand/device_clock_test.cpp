#include "hand/device_clock.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tactile_clay::hand::device_clock_test {
namespace {

using namespace std::chrono_literals;
using Time = DeviceClock::Time;

Time fromSeconds(double s) {
  return Time(std::llround(s * 1e9));
}

// 110 samples per second for a minute. Each is received after 2 ms plus an exponential delay of 3 ms in the
// mean, in order. The drift of two quartz clocks and the 10 s of the envelope limit the error to 1 ms. After
// a few hundred samples, the minimum delay of 10 s is within 0.1 ms of 2 ms.
TEST(DeviceClock, KeepsTheDevicesPaceUnderJitter) {
  for (const double drift : {-100e-6, 0.0, 100e-6}) {
    DeviceClock clock;
    std::mt19937 random(5);
    double received = 0.0, worst = 0.0, jitter = 0.0, late = 0.0;
    Time last = Time::min();
    int samples = 0;
    for (int i = 0; i < 110 * 60; ++i) {
      const double truth = 1000.0 + i / 110.0;
      const double delay = 0.002 - 0.003 * std::log((static_cast<double>(random()) + 1.0) / 4294967297.0);
      received = std::max(received, truth + delay);
      const Time mapped = clock(fromSeconds(50.0 + i / 110.0 * (1.0 + drift)), fromSeconds(received));
      EXPECT_GT(mapped, last);
      EXPECT_LE(mapped, fromSeconds(received));
      last = mapped;
      if (i < 5 * 110) continue;
      const double error = 1e-9 * static_cast<double>(mapped.count()) - (truth + 0.002);
      worst = std::max(worst, std::abs(error));
      jitter = std::max(jitter, received - truth - 0.002);
      late += received - truth - 0.002;
      ++samples;
    }
    EXPECT_LT(worst, 0.0011) << "drift " << drift;
    EXPECT_GT(jitter, 0.02) << "the test has too little jitter to be one";
    EXPECT_GT(late / samples, 0.0025);
    EXPECT_EQ(clock.restarts(), 0U);
  }
}

TEST(DeviceClock, ABurstAfterAStallKeepsItsTimes) {
  DeviceClock clock;
  for (int i = 0; i < 100; ++i) clock(1s + i * 10ms, 100s + i * 10ms);
  // Ten samples come at once, the last one in time.
  for (int i = 100; i < 110; ++i) EXPECT_EQ(clock(1s + i * 10ms, 100s + 1090ms), 100s + i * 10ms);
}

TEST(DeviceClock, StartsAnewWithTheService) {
  DeviceClock clock;
  for (int i = 0; i < 100; ++i) clock(900s + i * 10ms, 100s + i * 10ms);
  // The device's clock begins at zero again.
  EXPECT_EQ(clock(10ms, 101s + 40ms), 101s + 40ms);
  EXPECT_EQ(clock.restarts(), 1U);
  EXPECT_EQ(clock(20ms, 101s + 53ms), 101s + 50ms);
  // After a silence the clock may have been set, too, here forward by half a second.
  EXPECT_EQ(clock(3520ms, 104s + 50ms), 104s + 50ms);
  EXPECT_EQ(clock.restarts(), 2U);
}

TEST(DeviceClock, FollowsAClockThatStoodStill) {
  DeviceClock clock;
  for (int i = 0; i < 100; ++i) clock(1s + i * 10ms, 100s + i * 10ms);
  // Half a second later it goes on as if nothing had happened.
  for (int i = 100; i < 200; ++i) {
    const Time received = 100s + 500ms + i * 10ms;
    EXPECT_EQ(clock(1s + i * 10ms, received), received - (i < 125 ? 500ms : 0ms)) << i;
  }
  EXPECT_EQ(clock.restarts(), 1U);
}

TEST(DeviceClock, ADeviceWithoutAClockSamplesWhenItIsReceived) {
  DeviceClock clock;
  EXPECT_EQ(clock(0s, 100s), 100s);
  EXPECT_EQ(clock(0s, 101s), 101s);
  EXPECT_EQ(clock(0s, 101s), 101s + 1us);
}

}  // namespace
}  // namespace tactile_clay::hand::device_clock_test
