#include "device/sonic_surface_boards.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>

#include "device/sonic_surface.h"
#include "device/sonic_surface_terminal.h"
#include "support/shared_data.h"
#include "support/sounds.h"

namespace tactile_clay::device::sonic_surface_boards_test {
namespace {

using namespace std::chrono_literals;

void feed(SonicSurfaceBoards& boards, const std::vector<int>& bytes) {
  for (const int byte : bytes) boards.feed(static_cast<std::uint8_t>(byte));
}

std::size_t playing(const ultrasound::Drive& drive) {
  std::size_t count = 0;
  for (const float amplitude : drive.amplitude) count += amplitude > 0.0f ? 1 : 0;
  return count;
}

TEST(SonicSurfaceBoards, PlayTheBackBufferAfterASwap) {
  SonicSurfaceBoards boards;
  feed(boards, {0xFE, 8, 32, 31});
  EXPECT_FALSE(boards.sounds());
  EXPECT_TRUE(boards.may_sound());
  EXPECT_TRUE(boards.feed(0xFD));
  const auto drive = boards.drive();
  ASSERT_EQ(drive.phase.size(), 256u);
  EXPECT_EQ(playing(drive), 2u);
  EXPECT_FLOAT_EQ(drive.phase[0], static_cast<float>(M_PI / 2));
  EXPECT_EQ(drive.amplitude[1], 0.0f);
  EXPECT_FLOAT_EQ(drive.phase[2], static_cast<float>(31 * M_PI / 16));
  // The old pattern stays in the other buffer.
  boards.feed(0xFD);
  EXPECT_FALSE(boards.sounds());
  boards.feed(0xFD);
  EXPECT_TRUE(boards.sounds());
  EXPECT_EQ(boards.faults(), 0u);
}

TEST(SonicSurfaceBoards, AreSelectedByTheirBytes) {
  SonicSurfaceBoards boards(2);
  feed(boards, {0xC0, 0xFE, 4, 0xC1, 0xFE, 8, 12, 150, 151, 0xFD});
  const auto drive = boards.drive();
  ASSERT_EQ(drive.phase.size(), 512u);
  EXPECT_EQ(playing(drive), 3u);
  EXPECT_FLOAT_EQ(drive.phase[0], static_cast<float>(M_PI / 4));
  EXPECT_FLOAT_EQ(drive.phase[257], static_cast<float>(3 * M_PI / 4));
  EXPECT_EQ(boards.faults(), 0u);
  EXPECT_THROW(SonicSurfaceBoards(3), std::invalid_argument);
  EXPECT_THROW(SonicSurfaceBoards(2, true), std::invalid_argument);
}

TEST(SonicSurfaceBoards, StayDeselectedAndAreSilentWithoutClocks) {
  SonicSurfaceBoards boards(1);
  feed(boards, {0xFE, 4, 0xFD, 0xC1, 0xFE, 32, 32, 0xFD, 0xFD});
  EXPECT_FALSE(boards.selected(0));
  EXPECT_TRUE(boards.sounds()) << "swaps are obeyed, frames are not";
  boards.feed(150);
  EXPECT_FALSE(boards.sounds());
  EXPECT_TRUE(boards.may_sound());
  EXPECT_EQ(playing(boards.drive()), 0u);
  boards.feed(151);
  EXPECT_TRUE(boards.sounds());
  SonicSurfaceBoards secondary(1, false, 1);
  feed(secondary, {0xC0, 0xFE, 4, 0xFD});
  EXPECT_FALSE(secondary.sounds());
  feed(secondary, {0xC1, 0xFE, 4, 0xFD});
  EXPECT_TRUE(secondary.sounds());
}

TEST(SonicSurfaceBoards, CountWhatCorruptsAChannel) {
  SonicSurfaceBoards boards;
  feed(boards, {0xFE, 251, 0xFD});
  EXPECT_EQ(boards.faults(), 1u);
  EXPECT_FLOAT_EQ(boards.drive().phase[0], static_cast<float>(27 * M_PI / 16)) << "251 & 31";
  feed(boards, {0xFE});
  feed(boards, std::vector<int>(257, 0));
  EXPECT_EQ(boards.faults(), 2u) << "a channel too many";
  feed(boards, {0xA5});
  EXPECT_EQ(boards.faults(), 3u) << "the stock firmware knows no modulation";
}

TEST(SonicSurfaceBoards, OfTheTactileFirmwareModulateAndHaveHalfTheLevels) {
  SonicSurfaceBoards boards(1, true);
  feed(boards, {0xA5, 0xFE, 9, 0xFD});
  EXPECT_NEAR(boards.modulation(), 1250.0 / 6.0, 1e-9);
  EXPECT_FLOAT_EQ(boards.drive().phase[0], static_cast<float>(M_PI / 2));
  feed(boards, {0xFE, 0xC0, 0xFD});
  EXPECT_EQ(boards.faults(), 1u);
}

TEST(SonicSurfaceBoards, ChannelsAreWhereTheTableSays) {
  const std::filesystem::path table = sharedData("arrays/sonic_surface_channels.csv");
  std::ifstream file(table);
  if (!file) GTEST_SKIP() << "no " << table;
  const auto layout = SonicSurfaceBoards::layout();
  std::string line;
  std::getline(file, line);
  std::size_t rows = 0;
  for (; std::getline(file, line); ++rows) {
    int channel = 0, column = 0, row = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%d,%d,%d", &channel, &column, &row), 3) << line;
    const Eigen::Vector3d expected((column - 7.5) * 0.0105, (row - 7.5) * 0.0105, 0.0);
    EXPECT_LT((layout.position.at(static_cast<std::size_t>(channel)) - expected).norm(), 1e-9) << line;
  }
  EXPECT_EQ(rows, 256u);
}

class Terminal : public ::testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/terminal_testXXXXXX";
    ASSERT_NE(::mkdtemp(name), nullptr);
    folder = name;
    link = folder + "/port";
  }
  void TearDown() override { ::rmdir(folder.c_str()); }

  template <class Condition>
  static bool within(std::chrono::milliseconds patience, Condition condition) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      std::this_thread::sleep_for(2ms);
    }
    return true;
  }

  std::string folder, link;
};

/// The real driver, from a focal point to the field behind its wire.
TEST_F(Terminal, HearsWhatTheDriverPlays) {
  SonicSurfaceTerminal terminal(link, 1, false);
  SonicSurface driver;
  driver.open({{"port", link}});
  Emission emission;
  emission.points.resize(1);
  emission.points[0].position = {0.02, -0.01, 0.17};
  emission.points[0].intensity = 1.0;
  emission.modulation_frequency = 200.0;
  const Sound sound = soundOf(emission, &driver);
  ASSERT_TRUE(within(5s, [&] {
    driver.submit(sound);
    const auto state = terminal.state();
    return state.swaps > 60 && !state.patterns.empty() && std::abs(state.frequency - 200.0) < 40.0;
  }));
  const auto state = terminal.state();
  ASSERT_EQ(state.patterns.size(), 1u) << "the other buffer is silent";
  EXPECT_EQ(state.faults, 0u);
  EXPECT_EQ(playing(state.patterns[0].drive), 256u);
  // The focus stands where it was asked for: more there than 3 mm beside it on any side.
  const auto layout = SonicSurfaceBoards::layout();
  const ultrasound::Acoustics air;
  const auto pressure = [&](double x, double y) {
    return std::abs(ultrasound::pressureAt(layout, air, state.patterns[0].drive, {x, y, 0.17}));
  };
  const double there = pressure(0.02, -0.01);
  EXPECT_GT(there, 3500.0);
  for (const auto& [dx, dy] : {std::pair(0.003, 0.0), {-0.003, 0.0}, {0.0, 0.003}, {0.0, -0.003}})
    EXPECT_LT(pressure(0.02 + dx, -0.01 + dy), there);
  driver.stop();
  EXPECT_TRUE(within(1s, [&] { return terminal.state().patterns.empty(); }));
}

TEST_F(Terminal, SaysWhereItsLinkCannotBe) {
  try {
    SonicSurfaceTerminal(folder + "/no/such/port", 1, false);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("/no/such/port"), std::string::npos);
  }
  // A file that is not a link is not replaced.
  std::ofstream(link) << "precious";
  EXPECT_THROW(SonicSurfaceTerminal(link, 1, false), std::runtime_error);
  std::string word;
  std::ifstream(link) >> word;
  EXPECT_EQ(word, "precious");
  ::unlink(link.c_str());
}

}  // namespace
}  // namespace tactile_clay::device::sonic_surface_boards_test
