#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "ultrasound/acoustic_field.h"

namespace tactile_clay::device::sonic_surface {

/// Bytes of the SonicSurface open array (github.com/upnalab/SonicSurface): serial, 230400 8N1, host to device
/// only.
///
/// A frame is 0xFE, a byte for each of 256 channels, and 0xFD. Channels go to the back buffer of the board;
/// 0xFD swaps the buffers of all boards. With the stock firmware 0xC0 and 0xC1 select the board of the
/// primary and of the secondary firmware, for good: the other one ignores frames until it is selected again.
/// So each frame selects its board, and finds it whatever was sent before.

enum class Firmware {
  stock,   // 32 phases; modulated by swapping with a silent buffer
  tactile  // 16 phases; the board modulates by itself; one board only
};

constexpr unsigned baud = 230400;
constexpr std::size_t channels = 256;  // of a board
constexpr std::uint8_t start_byte = 0xFE, swap_byte = 0xFD, first_board_byte = 0xC0, modulation_byte = 0xA0,
                       clocks_off_byte = 150, clocks_on_byte = 151;
constexpr std::uint8_t off = 32;  // a channel that is silent

/// Seconds that bytes take on the wire: a start bit, eight data bits, a stop bit.
constexpr double secondsOnWire(std::size_t bytes) {
  return 10.0 * static_cast<double>(bytes) / baud;
}

/// Column (along x) and row (along y) of each channel of a board, from 0.
std::array<std::pair<int, int>, channels> channelOrder();

/// What a board can emit of a drive: phases rounded to the firmware's levels, amplitudes to 0 or 1. A board
/// knows no amplitude, so an amplitude a below 1 switches off a share 1 - a of the channels, spread evenly
/// over the board, so that its foci become weaker by that much.
/// @param drive of one or more boards, in channel order
/// @param pattern of the channels that are on, any number: always the same ones for one, others for another
/// @param added turns that are added to the phases on the way to the wire, of each channel; empty: none
ultrasound::Drive emitted(const ultrasound::Drive& drive, Firmware firmware, unsigned pattern = 0,
                          const std::vector<double>& added = {});

/// The boards that a driver plays.
struct Boards {
  Firmware firmware = Firmware::stock;
  std::size_t count = 1;  // 2: one of the primary, one of the secondary firmware (stock only)
  std::size_t first = 0;  // of a single one with the stock firmware: 0 the primary, 1 the secondary
};

/// Frame of such a drive.
/// @param added as of emitted()
/// @throws std::invalid_argument if the drive has not 256 channels a board, or there are others than 1 or 2
/// boards (tactile: 1)
std::vector<std::uint8_t> frame(const ultrasound::Drive& drive, const Boards& boards,
                                const std::vector<double>& added = {});

/// Silence, and boards that take frames, from whatever state they are in: selected or not, in mid-frame,
/// clocks off, patterns in either buffer. A buffer is silenced by a frame, and the swap behind it brings the
/// other one forward: so two frames each. Of the stock firmware it silences a second board too, even if none
/// is wanted. Its clocks are off meanwhile, for then boards are silent with the first byte. In the end the
/// first board is selected, as programs expect it that know of one board only.
std::vector<std::uint8_t> silence(const Boards& boards);

/// Byte that sets the tactile firmware's modulation to 1250 / (s + 1) Hz, s = 0 to 31, closest to
/// `frequency`.
/// @throws std::invalid_argument for a frequency below 39 or above 1250 Hz
std::uint8_t modulation(double frequency);

}  // namespace tactile_clay::device::sonic_surface
