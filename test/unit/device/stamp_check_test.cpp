#include "device/stamp_check.h"

#include <gtest/gtest.h>

namespace tactile_clay::device::stamp_check_test {
namespace {

using Mode = StampCheck::Mode;
constexpr double timeout = 0.1;
constexpr double day = 86400.0;

StampCheck::Age last(StampCheck& check, double behind, int stamps, bool played = false) {
  StampCheck::Age age;
  for (int i = 0; i < stamps; ++i) age = check(behind, played);
  return age;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(StampCheck, OffSaysThatAllIsNew) {
  StampCheck check(Mode::off, timeout);
  EXPECT_EQ(check(5.0).age, 0.0);
  EXPECT_EQ(check(5.0).clocks, "");
}

TEST(StampCheck, StampsOfThisClockTellTheirAge) {
  for (const Mode mode : {Mode::on, Mode::found}) {
    StampCheck check(mode, timeout);
    EXPECT_EQ(check(0.02).age, 0.02);
    const auto late = check(0.5);
    EXPECT_EQ(late.age, 0.5);
    EXPECT_EQ(late.clocks, "") << "one late frame says nothing of clocks";
  }
}

TEST(StampCheck, ClocksThatAreApartAreNamedWithTheirOffset) {
  for (const Mode mode : {Mode::on, Mode::found}) {
    for (const double behind : {5.0, -5.0, 60.0, -1.5}) {
      StampCheck check(mode, timeout);
      const auto age = check(behind);
      EXPECT_EQ(age.age, behind);
      EXPECT_TRUE(contains(age.clocks, "compare the hosts' clocks")) << age.clocks;
      EXPECT_FALSE(check.ofRecording());
    }
    StampCheck check(mode, timeout);
    EXPECT_TRUE(contains(check(5.0).clocks, "5.00 s behind"));
    EXPECT_TRUE(contains(check(-5.0).clocks, "5.00 s ahead"));
    EXPECT_TRUE(contains(check(-0.3).clocks, "0.30 s ahead")) << "nothing comes from the future";
  }
}

TEST(StampCheck, WhatIsSteadilyLateMayBeAClock) {
  StampCheck check(Mode::on, timeout);
  EXPECT_EQ(last(check, 0.4, 29).clocks, "");
  EXPECT_TRUE(contains(check(0.3).clocks, "0.30 s behind"));
  check(0.01);
  EXPECT_EQ(last(check, 0.4, 29).clocks, "");
}

TEST(StampCheck, ARecordingIsFoundByItsDistanceOrByItsPlayer) {
  StampCheck far(Mode::found, timeout);
  EXPECT_EQ(far(day).age, 0.0);
  EXPECT_TRUE(far.ofRecording());
  StampCheck near(Mode::found, timeout);
  EXPECT_EQ(near(20.0, true).age, 0.0);
  EXPECT_TRUE(near.ofRecording());
  StampCheck with_its_clock(Mode::found, timeout);  // rosbag play --clock
  EXPECT_EQ(with_its_clock(0.3, true).age, 0.3);
  EXPECT_FALSE(with_its_clock.ofRecording());
  StampCheck on(Mode::on, timeout);
  EXPECT_EQ(on(day).age, day) << "only where a recording may come";
}

TEST(StampCheck, WhatWasLiveStaysSoUntilSomebodyElseSends) {
  StampCheck check(Mode::found, timeout);
  check(0.02);
  EXPECT_EQ(check(day).age, day) << "a clock was set";
  EXPECT_TRUE(contains(check(day).clocks, "compare"));
  check.restart();
  EXPECT_EQ(check(day).age, 0.0);
}

TEST(StampCheck, NoStampIsTooBad) {
  StampCheck check(Mode::on, timeout);
  EXPECT_FALSE(check(std::numeric_limits<double>::quiet_NaN()).age <= timeout);
  EXPECT_TRUE(contains(check(1e12).clocks, "compare"));
}

}  // namespace
}  // namespace tactile_clay::device::stamp_check_test
