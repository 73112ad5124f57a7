#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "ultrasound/acoustic_field.h"

namespace tactile_clay::device::sonic_surface {

/// Bytes of the SonicSurface open array (github.com/upnalab/SonicSurface): serial, 230400 8N1, from host to
/// device only.
///
/// A frame is 0xFE, one byte for each of 256 channels, and 0xFD. Channels are written to the back buffer of
/// the board; 0xFD swaps the buffers of all boards. With the stock firmware, 0xC0 selects the board of the
/// primary firmware and 0xC1 the board of the secondary firmware. A selection lasts: the other board ignores
/// frames until it is selected again. So each frame selects its board first, and reaches it whatever was sent
/// before.

enum class Firmware {
  stock,   // 32 phases; modulated by swapping with a silent buffer
  tactile  // 16 phases; the board modulates by itself; one board only
};

constexpr unsigned baud = 230400;
constexpr std::size_t channels = 256;  // of one board
constexpr std::uint8_t start_byte = 0xFE, swap_byte = 0xFD, first_board_byte = 0xC0, modulation_byte = 0xA0,
                       clocks_off_byte = 150, clocks_on_byte = 151;
constexpr std::uint8_t off = 32;  // value of a silent channel

/// Seconds that bytes take on the wire: each has a start bit, eight data bits and a stop bit.
constexpr double secondsOnWire(std::size_t bytes) {
  return 10.0 * static_cast<double>(bytes) / baud;
}

/// Column (along x) and row (along y) of each channel of a board, from 0.
std::array<std::pair<int, int>, channels> channelOrder();

/// The part of a drive that a board can emit: phases rounded to the firmware's levels, amplitudes to 0 or 1.
/// A board cannot set an amplitude. So an amplitude a below 1 switches off a share 1 - a of the channels,
/// spread evenly over the board, and the foci become weaker by this share.
/// @param drive of one or more boards, in channel order
/// @param pattern any number; selects which channels are on. The same number always gives the same channels,
/// another number gives other channels
/// @param added turns added to the phase of each channel before it is sent; empty: none
ultrasound::Drive emitted(const ultrasound::Drive& drive, Firmware firmware, unsigned pattern = 0,
                          const std::vector<double>& added = {});

/// The boards that a driver plays.
struct Boards {
  Firmware firmware = Firmware::stock;
  std::size_t count = 1;  // 2: one of the primary, one of the secondary firmware (stock only)
  std::size_t first = 0;  // firmware of a single stock board: 0 primary, 1 secondary
};

/// Bytes of the frame for a drive.
/// @param added as in emitted()
/// @throws std::invalid_argument if the drive does not have 256 channels for each board, or if the number of
/// boards is not 1 or 2 (tactile: 1)
std::vector<std::uint8_t> frame(const ultrasound::Drive& drive, const Boards& boards,
                                const std::vector<double>& added = {});

/// Bytes that silence the boards and leave them ready for frames, whatever their state: selected or not, in
/// the middle of a frame, with clocks off, with patterns in either buffer. A frame silences one buffer, and
/// its swap brings the other one forward. So each board gets two frames. With the stock firmware a second
/// board is silenced, too, even if it is not used. The clocks are off meanwhile, so the boards are silent
/// from the first byte on. At the end the first board is selected, because programs that know only one board
/// expect this.
std::vector<std::uint8_t> silence(const Boards& boards);

/// Byte that sets the tactile firmware's modulation to 1250 / (s + 1) Hz, s = 0 to 31, closest to
/// `frequency`.
/// @throws std::invalid_argument for a frequency below 39 or above 1250 Hz
std::uint8_t modulation(double frequency);

}  // namespace tactile_clay::device::sonic_surface
