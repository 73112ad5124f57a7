#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "device/array_device.h"
#include "device/sonic_surface_protocol.h"

/// Boards, drives and a terminal for the tests of SonicSurface boards.
namespace tactile_clay::device {

inline constexpr sonic_surface::Boards one_board{};
inline constexpr sonic_surface::Boards two_boards{sonic_surface::Firmware::stock, 2, 0};
inline constexpr sonic_surface::Boards tactile_board{sonic_surface::Firmware::tactile, 1, 0};

inline ultrasound::Drive uniform(std::size_t size, float phase, float amplitude) {
  return {std::vector<float>(size, phase), std::vector<float>(size, amplitude)};
}

inline std::size_t countOff(const std::vector<std::uint8_t>& frame) {
  return static_cast<std::size_t>(std::count(frame.begin(), frame.end(), 32));
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

}  // namespace tactile_clay::device
