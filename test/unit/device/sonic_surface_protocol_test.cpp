#include "device/sonic_surface_protocol.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "device/sonic_surface_boards.h"
#include "sonic_surface_fixture.h"
#include "support/shared_data.h"

namespace tactile_clay::device::sonic_surface_protocol_test {
namespace {

using sonic_surface::Boards;
using sonic_surface::Firmware;

TEST(SonicSurfaceProtocol, FrameOfOneBoard) {
  ultrasound::Drive drive = uniform(256, 0.0f, 1.0f);
  for (std::size_t n = 0; n < 256; ++n) drive.phase[n] = static_cast<float>(n % 32 * 2.0 * M_PI / 32);
  drive.amplitude[5] = 0.0f;
  const auto bytes = sonic_surface::frame(drive, one_board);
  ASSERT_EQ(bytes.size(), 259u);
  EXPECT_EQ(bytes[0], 0xC0);
  EXPECT_EQ(bytes[1], 0xFE);
  EXPECT_EQ(bytes.back(), 0xFD);
  for (std::size_t n = 0; n < 256; ++n) EXPECT_EQ(bytes[n + 2], n == 5 ? 32 : n % 32) << n;
  EXPECT_EQ(sonic_surface::frame(drive, {Firmware::stock, 1, 1}).front(), 0xC1)
      << "the secondary firmware alone";
  EXPECT_EQ(sonic_surface::frame(drive, tactile_board).size(), 258u) << "which knows no selection";
}

TEST(SonicSurfaceProtocol, FrameOfTwoBoards) {
  ultrasound::Drive drive = uniform(512, 0.0f, 1.0f);
  for (std::size_t n = 256; n < 512; ++n) drive.phase[n] = static_cast<float>(M_PI);
  const auto bytes = sonic_surface::frame(drive, two_boards);
  ASSERT_EQ(bytes.size(), 517u);
  EXPECT_EQ((std::vector<int>{bytes[0], bytes[1], bytes[258], bytes[259], bytes[516]}),
            (std::vector<int>{0xC0, 0xFE, 0xC1, 0xFE, 0xFD}));
  for (std::size_t n = 0; n < 256; ++n) {
    EXPECT_EQ(bytes[n + 2], 0);
    EXPECT_EQ(bytes[n + 260], 16);
  }
  EXPECT_THROW(sonic_surface::frame(drive, tactile_board), std::invalid_argument);
  EXPECT_THROW(sonic_surface::frame(uniform(200, 0, 1), one_board), std::invalid_argument);
}

TEST(SonicSurfaceProtocol, RoundsPhasesToTheNearestLevel) {
  for (const auto firmware : {Firmware::stock, Firmware::tactile}) {
    const int levels = firmware == Firmware::stock ? 32 : 16;
    for (const double turns : {-3.26, -1e-6, 0.0, 0.24, 0.499, 0.99, 0.9999, 7.1}) {
      ultrasound::Drive drive = uniform(256, static_cast<float>(turns * 2.0 * M_PI), 1.0f);
      const int value = *(sonic_surface::frame(drive, {firmware, 1, 0}).end() - 2);
      const double error = std::remainder(value / 32.0 - turns, 1.0);
      EXPECT_LE(std::abs(error), 0.5 / levels + 1e-5) << turns;
      EXPECT_LT(value, 32);
      EXPECT_EQ(value % (32 / levels), 0) << "the tactile firmware leaves out the lowest bit";
      EXPECT_NEAR(
          std::remainder(sonic_surface::emitted(drive, firmware).phase[0] / (2 * M_PI) - value / 32.0, 1.0),
          0.0, 1e-6);
    }
  }
}

TEST(SonicSurfaceProtocol, SwitchesOffChannelsEvenlyForLessAmplitude) {
  const auto order = sonic_surface::channelOrder();
  for (const float amplitude : {0.0f, 0.1f, 0.25f, 0.5f, 0.8f, 1.0f}) {
    const ultrasound::Drive drive = uniform(256, 0.0f, amplitude);
    const auto bytes = sonic_surface::frame(drive, one_board);
    EXPECT_NEAR(static_cast<double>(256 - countOff(bytes)), 256.0 * amplitude, 1.0);
    // Each quarter of the board has its share of them.
    double on[4] = {};
    const auto emitted = sonic_surface::emitted(drive, Firmware::stock);
    for (std::size_t n = 0; n < 256; ++n) {
      EXPECT_EQ(emitted.amplitude[n], bytes[n + 2] == 32 ? 0.0f : 1.0f);
      on[2 * (order[n].first / 8) + order[n].second / 8] += emitted.amplitude[n];
    }
    for (const double quarter : on) EXPECT_NEAR(quarter, 64.0 * amplitude, 3.0) << amplitude;
  }
}

/// Expects, from every state of the boards: both buffers silent, clocks on, the first board selected. If
/// there are clocks to switch off, silence begins with the first byte.
/// @param prefix sent before
void expectSilence(const Boards& boards, SonicSurfaceBoards there, std::size_t count) {
  const std::size_t faults = there.faults();
  const auto bytes = sonic_surface::silence(boards);
  std::size_t loud = 0;
  for (const std::uint8_t byte : bytes) {
    there.feed(byte);
    loud += there.sounds() ? 1 : 0;
  }
  EXPECT_FALSE(there.may_sound());
  EXPECT_TRUE(there.clocks());
  EXPECT_EQ(there.faults(), faults) << "no byte that the boards do not know";
  if (boards.firmware == Firmware::stock) {
    EXPECT_EQ(loud, 0u);
  }
  // And it plays what comes next, on each of its boards.
  const std::size_t board = boards.count == 1 && count == 2 ? boards.first : 0;
  EXPECT_TRUE(there.selected(board)) << "as programs expect it that know of one board only";
  ultrasound::Drive drive = uniform(256 * boards.count, static_cast<float>(M_PI), 1.0f);
  for (const std::uint8_t byte : sonic_surface::frame(drive, boards)) there.feed(byte);
  const auto playing = there.drive();
  for (std::size_t n = 0; n < 256 * count; ++n) {
    const bool wanted = n >= 256 * board && n < 256 * (board + boards.count);
    ASSERT_EQ(playing.amplitude[n], wanted ? 1.0f : 0.0f) << n;
    if (wanted) {
      ASSERT_FLOAT_EQ(playing.phase[n], static_cast<float>(M_PI)) << n;
    }
  }
  there.feed(sonic_surface::swap_byte);
  EXPECT_FALSE(there.sounds()) << "behind it is silence";
}

/// Any program may have run before: random bytes, more often those with an effect, stopped anywhere. Then the
/// states that these may miss.
TEST(SonicSurfaceProtocol, SilenceIsRightFromAnyState) {
  std::mt19937 random(5);
  const auto choose = [&](int below) { return std::uniform_int_distribution<int>(0, below - 1)(random); };
  constexpr int telling[] = {0xFE, 0xFD, 0xC0, 0xC1, 150, 151, 0xA5, 32};
  struct Bench {
    Boards boards;
    std::size_t there, first;
  };
  const Bench benches[] = {{one_board, 1, 0},
                           {{Firmware::stock, 1, 1}, 1, 1},
                           {two_boards, 2, 0},
                           {one_board, 2, 0},                // a second one that nobody asked for
                           {{Firmware::stock, 1, 1}, 2, 0},  // the primary one is not asked for
                           {tactile_board, 1, 0}};
  std::size_t deselected = 0, without_clocks = 0, loud = 0;
  for (const Bench& bench : benches) {
    const bool tactile = bench.boards.firmware == Firmware::tactile;
    for (int k = 0; k < 300; ++k) {
      SonicSurfaceBoards there(bench.there, tactile, bench.first);
      for (int n = choose(1500); n > 0; --n)
        there.feed(
            static_cast<std::uint8_t>(choose(8) == 0 ? telling[choose(8)] : choose(k % 2 == 0 ? 33 : 256)));
      deselected += there.selected(0) ? 0 : 1;
      without_clocks += there.clocks() ? 0 : 1;
      loud += there.sounds() ? 1 : 0;
      expectSilence(bench.boards, there, bench.there);
      if (HasFatalFailure()) return;
    }
    for (const bool clocks_off : {false, true}) {
      for (const int select : {0xC0, 0xC1, 0}) {
        for (const int sent :
             {0, 1, 255, 256, 257, 300, 511, 512}) {  // channels of a frame that does not end
          SonicSurfaceBoards there(bench.there, tactile, bench.first);
          std::vector<int> bytes;
          for (const int board : {0xC0, 0xC1}) {
            if (!tactile) bytes.push_back(board);
            bytes.push_back(0xFE);
            bytes.insert(bytes.end(), 256, 7);
          }
          bytes.push_back(0xFD);
          bytes.push_back(0xFE);
          bytes.insert(bytes.end(), static_cast<std::size_t>(sent), 9);
          if (!tactile && select != 0) bytes.push_back(select);
          if (!tactile && clocks_off) bytes.push_back(150);
          for (const int byte : bytes) there.feed(static_cast<std::uint8_t>(byte));
          expectSilence(bench.boards, there, bench.there);
          if (HasFatalFailure()) return;
        }
      }
    }
  }
  EXPECT_GT(deselected, 300u) << "the states are of every kind";
  EXPECT_GT(without_clocks, 300u);
  EXPECT_GT(loud, 300u);
}

TEST(SonicSurfaceProtocol, SilenceSilencesItsOwnBoardsFirst) {
  const auto bytes = sonic_surface::silence(one_board);
  EXPECT_EQ(bytes[0], 150) << "no clocks, no sound";
  EXPECT_EQ(bytes[1], 0xC0);
  EXPECT_EQ(bytes[259], 0xFD);
  EXPECT_EQ(bytes[260], 0xC0);
  EXPECT_EQ(bytes.back(), 0xC0);
  EXPECT_LT(sonic_surface::secondsOnWire(bytes.size()), 0.046);
  EXPECT_EQ(sonic_surface::silence(two_boards).size(), 2 * 517u + 3u);
  EXPECT_EQ(sonic_surface::silence(tactile_board).size(), 2 * 258u);
}

TEST(SonicSurfaceProtocol, ModulationByte) {
  EXPECT_EQ(sonic_surface::modulation(200.0), 0xA5);  // 1250/6 = 208 Hz
  EXPECT_EQ(sonic_surface::modulation(1250.0), 0xA0);
  EXPECT_EQ(sonic_surface::modulation(40.0), 0xA0 | 30);
  for (const double bad : {0.0, 20.0, 2000.0, std::nan("")})
    EXPECT_THROW(sonic_surface::modulation(bad), std::invalid_argument) << bad;
}

TEST(SonicSurfaceProtocol, ChannelsAreAPermutationOfTheGrid) {
  std::set<std::pair<int, int>> cells;
  for (const auto& cell : sonic_surface::channelOrder()) cells.insert(cell);
  EXPECT_EQ(cells.size(), 256u);
  EXPECT_EQ(*cells.begin(), std::make_pair(0, 0));
  EXPECT_EQ(*cells.rbegin(), std::make_pair(15, 15));
}

TEST(SonicSurfaceProtocol, ChannelsAreThoseOfTheTable) {
  std::ifstream file(sharedData("arrays/sonic_surface_channels.csv"));
  if (!file) GTEST_SKIP() << "no arrays/sonic_surface_channels.csv in TACTILE_CLAY_DATA";
  const auto order = sonic_surface::channelOrder();
  std::string line;
  std::getline(file, line);
  std::size_t lines = 0;
  for (; std::getline(file, line); ++lines) {
    std::size_t channel = 0;
    std::pair<int, int> cell;
    ASSERT_EQ(std::sscanf(line.c_str(), "%zu,%d,%d", &channel, &cell.first, &cell.second), 3) << line;
    EXPECT_EQ(order.at(channel), cell) << "channel " << channel;
  }
  EXPECT_EQ(lines, 256u);
}

}  // namespace
}  // namespace tactile_clay::device::sonic_surface_protocol_test
