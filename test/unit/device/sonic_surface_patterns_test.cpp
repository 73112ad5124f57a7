#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "device/sonic_surface.h"
#include "device/sonic_surface_boards.h"
#include "device/sonic_surface_protocol.h"
#include "sonic_surface_fixture.h"
#include "support/sounds.h"
#include "ultrasound/focus_peak.h"

namespace tactile_clay::device::sonic_surface_patterns_test {
namespace {

/// m, from a focus to the peak of the field near it.
double distanceOfPeak(const ultrasound::ArrayLayout& layout, const ultrasound::Drive& drive,
                      const Eigen::Vector3d& focus) {
  const auto amplitude = [&](const Eigen::Vector3d& at) {
    return std::abs(ultrasound::pressureAt(layout, ultrasound::Acoustics(), drive, at));
  };
  return (ultrasound::peakNear(focus, amplitude) - focus).norm();
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

/// Two channels make fringes, and one makes a wave: a sound has its peak at the focal point, however weak it
/// is.
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

}  // namespace
}  // namespace tactile_clay::device::sonic_surface_patterns_test
