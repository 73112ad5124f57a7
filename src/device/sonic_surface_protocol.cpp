#include "device/sonic_surface_protocol.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace tactile_clay::device::sonic_surface {
namespace {

constexpr int side = 16;

/// The level nearest to a phase (rad) and some turns.
int level(float phase, double turns, int levels) {
  const auto nearest = std::lround((phase / (2.0 * M_PI) + turns) * levels);
  return static_cast<int>(((nearest % levels) + levels) % levels);
}

/// Amplitude above which each channel of a board is on: (rank + 1/2) / 256 in the order of the additive
/// sequence R2 (Roberts 2018, generalised golden ratio), which spreads over the plane at every length.
/// @param pattern shifts that sequence by the golden ratio each
std::array<float, channels> thresholds(unsigned pattern) {
  const auto order = channelOrder();
  std::array<double, channels> value{};
  for (std::size_t n = 0; n < channels; ++n) {
    const double x = 0.7548776662466927 * order[n].first + 0.5698402909980532 * order[n].second +
                     0.6180339887498949 * pattern;
    value[n] = x - std::floor(x);
  }
  std::array<std::size_t, channels> ranked{};
  std::iota(ranked.begin(), ranked.end(), std::size_t{0});
  std::sort(ranked.begin(), ranked.end(), [&](auto a, auto b) { return value[a] < value[b]; });
  std::array<float, channels> result{};
  for (std::size_t rank = 0; rank < channels; ++rank)
    result[ranked[rank]] = (static_cast<float>(rank) + 0.5f) / channels;
  return result;
}

}  // namespace

std::array<std::pair<int, int>, channels> channelOrder() {
  // The shift registers of a board each serve 4 columns by 2 rows, from the upper left downwards.
  constexpr std::array<std::pair<int, int>, 8> of_register = {
      {{0, 1}, {2, 1}, {3, 1}, {1, 0}, {0, 0}, {3, 0}, {2, 0}, {1, 1}}};
  std::array<std::pair<int, int>, channels> order;
  for (int n = 0; n < static_cast<int>(channels); ++n) {
    const auto& cell = of_register[static_cast<std::size_t>(n % 8)];
    order[static_cast<std::size_t>(n)] = {n / 64 * 4 + cell.first, side - 2 - n / 8 % 8 * 2 + cell.second};
  }
  return order;
}

ultrasound::Drive emitted(const ultrasound::Drive& drive, Firmware firmware, unsigned pattern,
                          const std::vector<double>& added) {
  const std::array<float, channels> threshold = thresholds(pattern);
  const int levels = firmware == Firmware::stock ? 32 : 16;
  ultrasound::Drive result = drive;
  for (std::size_t n = 0; n < drive.phase.size(); ++n) {
    const double more = added.empty() ? 0.0 : added[n];  // turns
    const double heard = static_cast<double>(level(drive.phase[n], more, levels)) / levels - more;
    result.phase[n] = static_cast<float>((heard - std::floor(heard)) * 2.0 * M_PI);
    result.amplitude[n] = drive.amplitude[n] > threshold[n % channels] ? 1.0f : 0.0f;
  }
  return result;
}

std::vector<std::uint8_t> frame(const ultrasound::Drive& drive, const Boards& boards,
                                const std::vector<double>& added) {
  const std::size_t maximum = boards.firmware == Firmware::stock ? 2 : 1;
  if (boards.count < 1 || boards.count > maximum || drive.phase.size() != boards.count * channels ||
      drive.amplitude.size() != drive.phase.size())
    throw std::invalid_argument("sonic_surface: drive of " + std::to_string(drive.phase.size()) +
                                " channels, expected 256 for each of 1 to " + std::to_string(maximum) +
                                " boards");
  const std::array<float, channels> threshold = thresholds(0);
  std::vector<std::uint8_t> bytes;
  for (std::size_t n = 0; n < drive.phase.size(); ++n) {
    if (n % channels == 0) {
      if (boards.firmware == Firmware::stock)
        bytes.push_back(static_cast<std::uint8_t>(first_board_byte + boards.first + n / channels));
      bytes.push_back(start_byte);
    }
    const double more = added.empty() ? 0.0 : added[n];
    // The tactile firmware leaves out the lowest bit.
    bytes.push_back(drive.amplitude[n] > threshold[n % channels]
                        ? static_cast<std::uint8_t>(boards.firmware == Firmware::stock
                                                        ? level(drive.phase[n], more, 32)
                                                        : 2 * level(drive.phase[n], more, 16))
                        : off);
  }
  bytes.push_back(swap_byte);
  return bytes;
}

std::vector<std::uint8_t> silence(const Boards& boards) {
  const auto twice = [](const Boards& some) {
    const std::vector<float> none(some.count * channels, 0.0f);
    std::vector<std::uint8_t> bytes = frame({none, none}, some);
    const std::vector<std::uint8_t> once = bytes;
    bytes.insert(bytes.end(), once.begin(), once.end());
    return bytes;
  };
  std::vector<std::uint8_t> bytes = twice(boards);
  if (boards.firmware == Firmware::tactile)
    return bytes;  // has neither clocks to switch nor boards to select
  bytes.insert(bytes.begin(), clocks_off_byte);
  if (boards.count == 1) {
    const std::vector<std::uint8_t> other = twice({boards.firmware, 1, 1 - boards.first});
    bytes.insert(bytes.end(), other.begin(), other.end());
  }
  bytes.push_back(clocks_on_byte);
  bytes.push_back(static_cast<std::uint8_t>(first_board_byte + boards.first));
  return bytes;
}

std::uint8_t modulation(double frequency) {
  if (!(frequency >= 39.0 && frequency <= 1250.0))
    throw std::invalid_argument("sonic_surface: modulation of " + std::to_string(frequency) +
                                " Hz, expected 39 to 1250 Hz, which the tactile firmware can do");
  const auto nearest = [](double x) { return std::clamp(std::lround(x), 0L, 31L); };
  return static_cast<std::uint8_t>(modulation_byte | nearest(1250.0 / frequency - 1.0));
}

}  // namespace tactile_clay::device::sonic_surface
