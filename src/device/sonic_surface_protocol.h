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
/// 0xFD swaps the buffers of all boards. With two boards 0xC0 and 0xC1 select whose channels follow.

enum class Firmware {
  stock,   // 32 phases; modulated by swapping with a silent buffer
  tactile  // 16 phases; the board modulates by itself; one board only
};

constexpr unsigned baud = 230400;
constexpr std::size_t channels = 256;  // of a board
constexpr std::uint8_t start_byte = 0xFE, swap_byte = 0xFD, first_board_byte = 0xC0, modulation_byte = 0xA0;
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
/// \param drive of one or more boards, in channel order
/// \param pattern of the channels that are on, any number: always the same ones for one, others for another
ultrasound::Drive emitted(const ultrasound::Drive& drive, Firmware firmware, unsigned pattern = 0);

/// Frame of such a drive; its length says how many boards it is for. \throws std::invalid_argument if it is
/// not 256 channels a board, 1 or 2 boards (tactile: 1)
std::vector<std::uint8_t> frame(const ultrasound::Drive& drive, Firmware firmware);

/// Both buffers off: two frames of silence. Right in whatever state the boards are, in mid-frame too.
std::vector<std::uint8_t> silence(std::size_t boards);

/// Byte that sets the tactile firmware's modulation to 1250 / (s + 1) Hz, s = 0 to 31, closest to
/// `frequency`.
/// \throws std::invalid_argument for a frequency below 39 or above 1250 Hz
std::uint8_t modulation(double frequency);

}  // namespace tactile_clay::device::sonic_surface
