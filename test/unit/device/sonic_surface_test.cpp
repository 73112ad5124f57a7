#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>
#include <sstream>

#include "device/sonic_surface.h"
#include "device/sonic_surface_boards.h"
#include "device/sonic_surface_corrections.h"
#include "device/sonic_surface_protocol.h"
#include "support/error_of.h"
#include "support/scratch_folder.h"
#include "support/shared_data.h"
#include "support/sounds.h"
#include "ultrasound/focus_peak.h"

namespace tactile_clay::device {
namespace {

using sonic_surface::Boards;
using sonic_surface::Firmware;

constexpr Boards one_board{};
constexpr Boards two_boards{Firmware::stock, 2, 0};
constexpr Boards tactile_board{Firmware::tactile, 1, 0};

ultrasound::Drive uniform(std::size_t size, float phase, float amplitude) {
  return {std::vector<float>(size, phase), std::vector<float>(size, amplitude)};
}

/// m, from a focus to the peak of the field near it.
double distanceOfPeak(const ultrasound::ArrayLayout& layout, const ultrasound::Drive& drive,
                      const Eigen::Vector3d& focus) {
  const auto amplitude = [&](const Eigen::Vector3d& at) {
    return std::abs(ultrasound::pressureAt(layout, ultrasound::Acoustics(), drive, at));
  };
  return (ultrasound::peakNear(focus, amplitude) - focus).norm();
}

std::size_t countOff(const std::vector<std::uint8_t>& frame) {
  return static_cast<std::size_t>(std::count(frame.begin(), frame.end(), 32));
}

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

/// From every state of the boards: both buffers silent, clocks on, the first board selected, and the silence
/// is heard with the first byte where there are clocks to switch off.
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

/// Any program may have run before: random bytes, with those that do something more often than others,
/// stopped anywhere. Then the states that they may miss.
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

class SonicSurfaceCorrections : public ScratchFolder {
 protected:
  /// A table of 256 lines.
  /// @param other the line of channel 9
  static std::string table(const std::string& other) {
    std::string text = "# a board\nchannel,turns\n";
    for (int n = 0; n < 256; ++n)
      text += n == 9 ? other + "\n" : std::to_string(n) + "," + (n % 3 == 0 ? "flipped" : "0.03125") + "\n";
    return text;
  }

  std::string refusal(const std::string& path) {
    try {
      sonic_surface::readCorrections(path);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "read";
  }
};

TEST_F(SonicSurfaceCorrections, ComeFromATableOrAFirmware) {
  const auto turns = sonic_surface::readCorrections(write("board.csv", table("9,-0.25\r")));
  ASSERT_EQ(turns.size(), 256u);
  EXPECT_EQ(turns[0], 0.5);
  EXPECT_EQ(turns[1], 0.03125);
  EXPECT_EQ(turns[9], -0.25);
  std::string numbers = "16";
  for (int n = 1; n < 256; ++n) numbers += ", " + std::to_string(n % 33);
  const std::string vhdl =
      "type T is array (0 to 255) of integer range 0 to 32;\n\tconstant PHASE_CORRECTION : T := ";
  const auto of_firmware =
      sonic_surface::readCorrections(write("Distribute.vhd", vhdl + "(" + numbers + ");\n"));
  ASSERT_EQ(of_firmware.size(), 256u);
  EXPECT_EQ(of_firmware[0], 0.5);
  EXPECT_EQ(of_firmware[8], 0.25);
  EXPECT_NE(refusal(write("short.vhd", vhdl + "(1,2,3);")).find("has 3 numbers, expected"),
            std::string::npos);
  EXPECT_NE(refusal(write("none.vhd", "entity")).find("has no PHASE_CORRECTION"), std::string::npos);
  EXPECT_NE(refusal(write("word.vhd", vhdl + "(1,x);")).find("has 'x'"), std::string::npos);
}

TEST_F(SonicSurfaceCorrections, SayWhatIsWrong) {
  EXPECT_NE(refusal("/nowhere.csv").find("/nowhere.csv"), std::string::npos);
  EXPECT_NE(refusal(folder.string()).find(folder.string()), std::string::npos);
  EXPECT_NE(refusal(write("a", "channel;turns\n")).find("line 1 is 'channel;turns', expected the header"),
            std::string::npos);
  EXPECT_NE(refusal(write("a", table("9,much"))).find("line 12 is '9,much', expected turns from -1 to 1"),
            std::string::npos);
  EXPECT_NE(refusal(write("a", table("9,nan"))).find("expected turns"), std::string::npos);
  EXPECT_NE(refusal(write("a", table("9,1.5"))).find("expected turns"), std::string::npos);
  EXPECT_NE(refusal(write("a", table("256,0"))).find("expected a channel from 0 to 255"), std::string::npos);
  EXPECT_NE(refusal(write("a", table("8,0"))).find("expected each channel once"), std::string::npos);
  EXPECT_NE(refusal(write("a", table(""))).find("has no channel 9"), std::string::npos);
}

/// What is judged is what is heard: the phases on the wire, with what the board does to them taken in.
TEST_F(SonicSurfaceCorrections, AreInWhatIsSentAndNotInWhatIsHeard) {
  std::mt19937 random(4);
  const auto turn = [&] { return std::uniform_real_distribution<double>(-0.5, 0.5)(random); };
  ultrasound::Drive drive = uniform(256, 0.0f, 1.0f);
  std::vector<double> added(256);
  for (std::size_t n = 0; n < 256; ++n) {
    drive.phase[n] = static_cast<float>(2.0 * M_PI * turn());
    added[n] = turn();
  }
  for (const Firmware firmware : {Firmware::stock, Firmware::tactile}) {
    const Boards boards{firmware, 1, 0};
    const int levels = firmware == Firmware::stock ? 32 : 16;
    const ultrasound::Drive heard = sonic_surface::emitted(drive, firmware, 0, added);
    SonicSurfaceBoards board(1, firmware == Firmware::tactile);
    for (const std::uint8_t byte : sonic_surface::frame(heard, boards, added)) board.feed(byte);
    const ultrasound::Drive sent = board.drive();
    for (std::size_t n = 0; n < 256; ++n) {
      EXPECT_NEAR(
          std::remainder(sent.phase[n] / (2.0 * M_PI) - added[n] - heard.phase[n] / (2.0 * M_PI), 1.0), 0.0,
          1e-5);
      EXPECT_LE(std::abs(std::remainder((heard.phase[n] - drive.phase[n]) / (2.0 * M_PI), 1.0)),
                0.5 / levels + 1e-5);
    }
  }
}

/// A pseudo-terminal whose other end is read by the test.
class SonicSurfaceOnATerminal : public ::testing::Test {
 protected:
  void SetUp() override {
    master = ::posix_openpt(O_RDWR | O_NOCTTY);
    ASSERT_GE(master, 0);
    ASSERT_EQ(::grantpt(master), 0);
    ASSERT_EQ(::unlockpt(master), 0);
    options["port"] = ::ptsname(master);
  }
  void TearDown() override { ::close(master); }

  std::vector<std::uint8_t> read(std::size_t count) {
    std::vector<std::uint8_t> bytes;
    while (bytes.size() < count) {
      pollfd state{master, POLLIN, 0};
      if (::poll(&state, 1, 2000) <= 0) break;
      std::uint8_t buffer[256];
      const ssize_t got = ::read(master, buffer, std::min(sizeof buffer, count - bytes.size()));
      if (got <= 0) break;
      bytes.insert(bytes.end(), buffer, buffer + got);
    }
    return bytes;
  }

  Emission focus() const {
    Emission emission;
    emission.points.resize(1);
    emission.points[0].position = {0.01, 0.02, 0.15};
    emission.points[0].intensity = 1.0;
    return emission;
  }

  int master = -1;
  std::map<std::string, std::string> options;
};

TEST_F(SonicSurfaceOnATerminal, SendsWhatItSaysThatItSends) {
  const auto silence = sonic_surface::silence(one_board);
  {
    SonicSurface device;
    device.open(options);
    EXPECT_EQ(read(silence.size()), silence) << "first of all it silences both buffers";
    ASSERT_EQ(device.capabilities().layout.size(), 256u);
    EXPECT_NEAR(device.capabilities().max_rate, 89.0, 0.1);
    device.submit(soundOf(focus(), &device));
    const auto bytes = read(259);
    EXPECT_EQ(bytes, sonic_surface::frame(*device.drive(focus().points), one_board));
    EXPECT_EQ(read(3), (std::vector<std::uint8_t>{0xFD, 0xFD, 0xFD})) << "modulation";
    EXPECT_EQ(device.fault(), "");
  }
  // The driver's silence, or the guard's own where the guard dropped what was left; the last bytes tell.
  std::vector<std::uint8_t> rest = read(4096);
  const auto size = static_cast<std::ptrdiff_t>(silence.size());
  ASSERT_GE(rest.size(), silence.size());
  EXPECT_EQ(std::vector<std::uint8_t>(rest.end() - size, rest.end()), silence);
}

/// Contacts of recorded hands, weak enough to leave 40 to 160 of the 256 channels on. With the first pattern
/// of channels, each of these sets has a focus that is lost in side lobes, at 8 mm from any peak or nearly.
TEST_F(SonicSurfaceOnATerminal, TakesChannelsWithWhichEveryFocusIsAPeak) {
  SonicSurface device;
  device.open(options);
  const ultrasound::ArrayLayout layout = device.capabilities().layout;
  struct Focus {
    double x, y, z, intensity;
  };
  const std::vector<std::vector<Focus>> sets = {
      {{0.004, -0.041, 0.181, 0.653},
       {-0.021, -0.042, 0.173, 0.590},
       {0.063, -0.042, 0.182, 0.834},
       {0.046, -0.045, 0.188, 0.771},
       {0.065, 0.045, 0.164, 0.600},
       {0.049, 0.044, 0.178, 0.400},
       {-0.008, -0.040, 0.176, 0.200}},
      {{-0.022, -0.043, 0.170, 0.691},
       {0.062, -0.031, 0.182, 0.603},
       {0.048, -0.041, 0.189, 0.432},
       {0.033, 0.043, 0.167, 0.330},
       {-0.002, -0.041, 0.177, 0.779},
       {0.024, 0.034, 0.179, 0.483}},
      {{-0.004, -0.056, 0.188, 0.157}, {0.026, 0.022, 0.190, 0.270}, {-0.025, -0.048, 0.173, 0.108}},
      {{0.026, -0.002, 0.193, 0.239}, {-0.016, -0.061, 0.189, 0.065}},
      {{0.030, 0.000, 0.203, 0.243}, {-0.011, -0.065, 0.195, 0.085}, {0.040, 0.007, 0.190, 0.308}},
      {{-0.019, 0.067, 0.186, 0.053}, {0.028, -0.057, 0.189, 0.162}, {0.029, 0.062, 0.188, 0.211}},
      {{-0.025, 0.067, 0.182, 0.236},
       {0.028, 0.057, 0.190, 0.135},
       {-0.042, -0.064, 0.180, 0.109},
       {-0.015, -0.059, 0.188, 0.058}},
      {{0.056, 0.053, 0.189, 0.189}, {0.045, 0.061, 0.186, 0.277}}};
  for (std::size_t k = 0; k < sets.size(); ++k) {
    std::vector<ultrasound::FocalPoint> points;
    for (const Focus& focus : sets[k]) {
      points.emplace_back();
      points.back().position = {focus.x, focus.y, focus.z};
      points.back().intensity = focus.intensity;
    }
    const ultrasound::Drive drive = device.drive(points).value();
    for (const auto& point : points)
      EXPECT_LT(distanceOfPeak(layout, drive, point.position), 0.002)
          << "set " << k << ", focus at " << point.position.transpose();
  }
}

/// Two channels make fringes and one a wave: what sounds has its peak at the focal point, however weak it is.
TEST_F(SonicSurfaceOnATerminal, WhatIsTooWeakForAFocusIsSilent) {
  SonicSurface device;
  device.open(options);
  const ultrasound::ArrayLayout layout = device.capabilities().layout;
  std::mt19937 random(1);
  const auto between = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  int sounding = 0;
  constexpr int tries = 200;
  for (int k = 0; k < tries; ++k) {
    std::vector<ultrasound::FocalPoint> points(1);
    points[0].position = {between(-0.06, 0.06), between(-0.06, 0.06), between(0.12, 0.3)};
    points[0].intensity = between(0.002, 0.04);  // none to 10 of 256 channels
    const ultrasound::Drive drive = device.drive(points).value();
    const auto on = std::count(drive.amplitude.begin(), drive.amplitude.end(), 1.0f);
    if (on == 0) {
      EXPECT_LT(points[0].intensity, 4.0 / 256);
      continue;
    }
    ++sounding;
    EXPECT_LT(distanceOfPeak(layout, drive, points[0].position), 0.002)
        << on << " channels, focus at " << points[0].position.transpose();
  }
  EXPECT_GT(sounding, tries / 2);
}

/// A board whose firmware adds a table of its own to what it is sent: whole again with the option, nearly
/// nothing without it.
TEST_F(SonicSurfaceOnATerminal, TakesOffWhatTheFirmwareAdds) {
  std::mt19937 random(8);
  std::string text = "channel,turns\n";
  std::vector<double> table;
  for (int n = 0; n < 256; ++n) {
    table.push_back(std::uniform_int_distribution<int>(0, 31)(random) / 32.0);
    text += std::to_string(n) + "," + std::to_string(table.back()) + "\n";
  }
  const std::string path =
      (std::filesystem::temp_directory_path() / ("firmware_" + std::to_string(::getpid()) + ".csv")).string();
  std::ofstream(path) << text;
  const auto pressure = [&](bool told) {
    options["firmware_corrections"] = told ? path : "";
    options["guard"] = "false";
    SonicSurface device;
    device.open(options);
    read(sonic_surface::silence(one_board).size());
    const Sound sound = soundOf(focus(), &device);
    device.submit(sound);
    SonicSurfaceBoards board;
    for (const std::uint8_t byte : read(259)) board.feed(byte);
    ultrasound::Drive drive = board.drive();
    for (std::size_t n = 0; n < 256; ++n) drive.phase[n] += static_cast<float>(2.0 * M_PI * table[n]);
    const auto at = focus().points[0].position;
    const auto layout = SonicSurfaceBoards::layout();
    const double heard = std::abs(ultrasound::pressureAt(layout, {}, drive, at));
    if (told) {
      EXPECT_NEAR(heard, std::abs(ultrasound::pressureAt(layout, {}, sound.parts.at(0).drive, at)),
                  1e-3 * heard)
          << "what was judged is what is heard";
    }
    return heard;
  };
  const double told = pressure(true);
  ::close(master);
  SetUp();
  EXPECT_GT(told, 3500.0);
  EXPECT_LT(pressure(false), 0.3 * told);
  std::filesystem::remove(path);
}

TEST_F(SonicSurfaceOnATerminal, DoesNotPlayWhatTheWireIsTooSlowFor) {
  SonicSurface device;
  device.open(options);
  EXPECT_EQ(device.capabilities().modulations,
            (std::vector<ultrasound::Modulation>{ultrasound::Modulation::amplitude,
                                                 ultrasound::Modulation::field}));
  Emission path = focus();
  path.modulation = ultrasound::Modulation::spatiotemporal;
  EXPECT_THROW(device.submit(soundOf(path, &device)), std::runtime_error);
}

// A port of boards always has its guard. The multiplexer of pseudo-terminals stands for one: it is a
// terminal, and no end of a pseudo-terminal.
TEST_F(SonicSurfaceOnATerminal, NoPortOfBoardsIsWithoutItsGuard) {
  options["guard"] = "false";
  SonicSurface on_pseudo_terminal;
  EXPECT_NO_THROW(on_pseudo_terminal.open(options));
  options["port"] = "/dev/ptmx";
  SonicSurface on_port;
  EXPECT_EQ(errorOf([&] { on_port.open(options); }),
            "sonic_surface: '/dev/ptmx': guard is false, expected true on a port of boards");
}

// What goes over the wire is the pattern that was judged, channel by channel.
TEST_F(SonicSurfaceOnATerminal, PlaysAField) {
  options["guard"] = "false";
  SonicSurface device;
  device.open(options);
  read(sonic_surface::silence(one_board).size());
  Emission field{{}, 200.0, ultrasound::Modulation::field};
  for (int i = -4; i <= 4; ++i)
    for (int j = -4; j <= 4; ++j) {
      ultrasound::FocalPoint sample;
      sample.position = {0.005 * i, 0.005 * j, 0.2};
      sample.intensity = std::hypot(i, j) < 2.5 ? 0.3 : 0.0;
      field.points.push_back(sample);
    }
  for (const double amplitude : {1.0, 0.4}) {
    ultrasound::FieldSolverOptions maximum;
    maximum.amplitude = amplitude;
    const auto solution = device.field(field.points, maximum, {});
    ASSERT_TRUE(solution);
    const ultrasound::Drive& drive = solution->drives.at(0);
    const auto on = static_cast<double>(std::count(drive.amplitude.begin(), drive.amplitude.end(), 1.0f));
    EXPECT_LE(on, 256.0 * amplitude + 1.0);
    EXPECT_GT(on, 100.0 * amplitude);
    EXPECT_LT(solution->error, 0.7);
    ultrasound::FieldSolution judged = *solution;
    ultrasound::judgeField(device.capabilities().layout, {}, field.points, judged);
    EXPECT_NEAR(judged.error, solution->error, 1e-6);

    Sound sound{field, {}};
    Sound::Part part;
    part.what.points = field.points;
    part.drive = drive;
    sound.parts.push_back(part);
    device.submit(sound);
    const std::vector<std::uint8_t> expected = sonic_surface::frame(drive, one_board);
    std::vector<std::uint8_t> bytes = read(expected.size());  // swaps of the pattern before may come first
    for (int more = 0; more < 2000 && !std::equal(expected.rbegin(), expected.rend(), bytes.rbegin()); ++more)
      bytes.push_back(read(1).at(0));
    EXPECT_TRUE(std::equal(expected.rbegin(), expected.rend(), bytes.rbegin())) << amplitude;
    for (std::size_t n = 0; n < 256; ++n) {
      EXPECT_EQ(expected[n + 2] == 32, drive.amplitude[n] == 0.0f) << n;
      if (drive.amplitude[n] == 0.0f) continue;
      EXPECT_NEAR(std::remainder(expected[n + 2] / 32.0 - drive.phase[n] / (2.0 * M_PI), 1.0), 0.0, 1e-5)
          << n;
    }
  }
}

TEST_F(SonicSurfaceOnATerminal, GoesSilentWhenNotRenewed) {
  options["hold"] = "0.05";
  options["guard"] = "false";
  SonicSurface device;
  device.open(options);
  read(sonic_surface::silence(one_board).size());
  Emission steady = focus();
  steady.modulation_frequency = 0.0;
  device.submit(soundOf(steady, &device));
  EXPECT_NE(countOff(read(259)), 256u);
  EXPECT_EQ(read(sonic_surface::silence(one_board).size()), sonic_surface::silence(one_board));
}

TEST_F(SonicSurfaceOnATerminal, ChangeFromSteadyToModulatedPutsSilenceBehindThePattern) {
  options["guard"] = "false";
  SonicSurface device;
  device.open(options);
  read(sonic_surface::silence(one_board).size());
  Emission emission = focus();
  emission.modulation_frequency = 0.0;
  device.submit(soundOf(emission, &device));
  read(259);
  emission.modulation_frequency = 200.0;
  device.submit(soundOf(emission, &device));
  EXPECT_EQ(read(sonic_surface::silence(one_board).size()), sonic_surface::silence(one_board));
  EXPECT_EQ(countOff(read(259)), 0u);
}

TEST_F(SonicSurfaceOnATerminal, TellsWhenThePortIsGone) {
  SonicSurface device;
  device.open(options);
  read(sonic_surface::silence(one_board).size());
  ::close(master);
  for (int wait = 0; wait < 200 && device.fault().empty(); ++wait) ::usleep(10000);
  EXPECT_NE(device.fault().find("is gone"), std::string::npos) << device.fault();
  EXPECT_NE(device.fault().find(options["port"]), std::string::npos) << device.fault();
  EXPECT_THROW(device.submit(soundOf(focus(), &device)), std::runtime_error);
  device.stop();
}

TEST_F(SonicSurfaceOnATerminal, HasOneOwner) {
  SonicSurface device, second;
  device.open(options);
  EXPECT_THROW(second.open(options), std::runtime_error);
}

}  // namespace
}  // namespace tactile_clay::device
