#include "nodes/recording_time.h"
#include "nodes/player.h"

#include <gtest/gtest.h>

namespace tactile_clay::nodes {
namespace {

using namespace std::chrono_literals;

TEST(RecordingTime, LeavesRisingStampsAsTheyAre) {
  RecordingTime time;
  for (const auto stamp : {5ns, 1000000ns, 1000001ns, 7000000000ns}) EXPECT_EQ(time(stamp), stamp);
  EXPECT_EQ(time.repaired(), 0u);
}

TEST(RecordingTime, GoesOnByTheLastIntervalWhereAStampFallsBack) {
  RecordingTime time;
  time(1000ms);
  time(1010ms);
  EXPECT_EQ(time(200ms), 1020ms);  // a recording that starts again
  EXPECT_EQ(time(215ms), 1035ms);  // and keeps its own intervals from there
  EXPECT_EQ(time.repaired(), 1u);
}

TEST(RecordingTime, RepeatedAndZeroStampsStillRise) {
  RecordingTime time;
  auto before = time(0ns);
  EXPECT_GT(before, 0ns);
  for (const std::chrono::nanoseconds stamp : {0ns, 0ns, 40000000ns, 40000000ns, 0ns}) {
    const auto now = time(stamp);
    EXPECT_GT(now, before);
    before = now;
  }
}

TEST(RecordingTime, AGapIsNoInterval) {
  RecordingTime time;
  time(1000ms);
  time(1010ms);
  EXPECT_EQ(time(9000ms), 9000ms);
  EXPECT_EQ(time(100ms), 9010ms);
}

/// For any stamps the times rise, by no more than an hour, and stay below the largest stamp that ROS has.
TEST(RecordingTime, StampsOfAnotherAgeAreRepaired) {
  using std::chrono::nanoseconds;
  RecordingTime time;
  auto before = time(nanoseconds::max());
  EXPECT_LT(before, 1s);
  for (const nanoseconds stamp :
       {nanoseconds(4'294'967'295s), nanoseconds(1s), nanoseconds(2'147'483'647s), nanoseconds::min(),
        nanoseconds::max(), nanoseconds(2s), nanoseconds(2'010ms)}) {
    const auto now = time(stamp);
    EXPECT_GT(now, before);
    EXPECT_LE(now - before, 1h);
    before = now;
  }
}

TEST(IsPlayer, TakesTheNamesOfRosbagPlayAndNoOther) {
  for (const char* name : {"/play_1700000000123456789", "/rig/play_1700000000123456789",
                           "/play_my_host_4711_2305843009213693951"})
    EXPECT_TRUE(isPlayer(name)) << name;
  for (const char* name :
       {"/play_area", "/play_hands_2", "/play", "/player_1700000000123456789", "/tracker", ""})
    EXPECT_FALSE(isPlayer(name)) << name;
}

}  // namespace
}  // namespace tactile_clay::nodes
