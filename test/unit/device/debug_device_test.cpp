#include "device/debug_device.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "support/sounds.h"

namespace tactile_clay::device::debug_device_test {
namespace {

using std::chrono::milliseconds;

class DebugDeviceTest : public ::testing::Test {
 protected:
  std::vector<std::string> lines;
  std::chrono::nanoseconds now{0};
  DebugDevice device{[this](const std::string& line) { lines.push_back(line); }, [this] { return now; }};

  static Emission onePoint() {
    Emission emission;
    emission.points.emplace_back();
    emission.points[0].id = 3;
    emission.points[0].position = {0.01, -0.02, 0.2};
    emission.points[0].pressure = 2500.0;
    emission.points[0].intensity = 0.5;
    return emission;
  }
};

TEST_F(DebugDeviceTest, SaysWhatItWouldEmit) {
  device.open({});
  device.submit(soundOf(onePoint()));
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], "debug array: open");
  EXPECT_EQ(lines[1],
            "debug array: 1 points at 200 Hz am: [3] (0.0100 -0.0200 0.2000) m 2500 Pa intensity 0.500");
  EXPECT_TRUE(device.emitting());
  now += milliseconds(1000);
  device.submit({});
  EXPECT_EQ(lines.back(), "debug array: silence");
  EXPECT_FALSE(device.emitting());
}

TEST_F(DebugDeviceTest, KeepsToItsLineRateAndCountsAll) {
  device.open({{"log_rate", "10"}, {"port", "/dev/ttyUSB0"}});
  for (int i = 0; i < 100; ++i, now += milliseconds(10)) device.submit(soundOf(onePoint()));
  EXPECT_EQ(device.submissions(), 100u);
  EXPECT_EQ(lines.size(), 11u);  // open, and ten in a second
}

TEST_F(DebugDeviceTest, CanBeQuiet) {
  device.open({{"log_rate", "0"}});
  for (int i = 0; i < 5; ++i, now += milliseconds(5000)) device.submit(soundOf(onePoint()));
  EXPECT_EQ(device.submissions(), 5u);
  EXPECT_EQ(lines.size(), 1u);
}

TEST_F(DebugDeviceTest, RecordsThatItWasStopped) {
  device.open({});
  device.submit(soundOf(onePoint()));
  device.stop();
  EXPECT_FALSE(device.emitting());
  EXPECT_EQ(device.stops(), 1u);
  EXPECT_EQ(lines.back(), "debug array: stopped after 1 emissions");
  device.stop();  // again: counted, nothing to say
  EXPECT_EQ(device.stops(), 2u);
  EXPECT_EQ(lines.size(), 3u);
  device.submit(soundOf(onePoint()));
  EXPECT_TRUE(device.emitting());
}

TEST_F(DebugDeviceTest, StopDoesNotThrowWhenItsSinkDoes) {
  DebugDevice broken(
      [](const std::string& line) {
        if (line.find("stopped") != std::string::npos) throw std::runtime_error("full");
      },
      [] { return std::chrono::nanoseconds(0); });
  broken.open({});
  broken.submit(soundOf(onePoint()));
  broken.stop();
  EXPECT_FALSE(broken.emitting());
}

TEST_F(DebugDeviceTest, HasToBeOpened) {
  EXPECT_THROW(device.submit(soundOf(onePoint())), std::runtime_error);
  EXPECT_EQ(device.fault(), "not open");
  device.open({});
  EXPECT_EQ(device.fault(), "");
}

TEST_F(DebugDeviceTest, RefusesABadRate) {
  for (const char* bad : {"fast", "-1", "nan", "1x"}) {
    try {
      device.open({{"log_rate", bad}});
      FAIL() << bad;
    } catch (const std::runtime_error& e) {
      EXPECT_EQ(std::string(e.what()),
                "debug array: log_rate is '" + std::string(bad) + "', expected 0 or a positive number of Hz");
    }
  }
}

TEST_F(DebugDeviceTest, IsADeviceByDefault) {
  DebugDevice on_stderr;
  ArrayDevice& base = on_stderr;
  testing::internal::CaptureStderr();
  base.open({});
  base.submit(soundOf(onePoint()));
  base.stop();
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("debug array: 1 points"), std::string::npos);
}

}  // namespace
}  // namespace tactile_clay::device::debug_device_test
