#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "ultrasound/acoustic_field.h"
#include "ultrasound/array_layout.h"

namespace tactile_clay::device {

/// What SonicSurface boards do with the bytes that they are sent: a state machine of the table of their
/// protocol. It shares nothing with the driver's encoder, so that each tests the other.
///
/// | byte | meaning |
/// | --- | --- |
/// | 0xFE | the next channel is the first; not on a board that is deselected |
/// | 0-31 | phase of the next channel, in 32nds of a turn; 32: channel off |
/// | 0xFD | the two buffers change places, the next channel is the first; on all boards |
/// | 0xC0, 0xC1 | selects the boards of the primary, of the secondary firmware, and deselects the others: for
/// good (stock firmware) | | 150, 151 | shift clocks off, on, of all boards: without them nothing sounds
/// (stock firmware) | | 0xA0 + s | modulation of 1250 / (s + 1) Hz (tactile firmware) | | others | taken for
/// a phase, by their five lowest bits: a fault |
///
/// At power-on all boards are selected. Their buffers are silent here, as after a program that ended well.
class SonicSurfaceBoards {
 public:
  /// @param boards 1 or 2
  /// @param tactile firmware: 16 phases, modulated by the board
  /// @param first firmware of a single board: 0 primary, 1 secondary
  explicit SonicSurfaceBoards(std::size_t boards = 1, bool tactile = false, std::size_t first = 0);

  /// @return whether the byte made the boards swap their buffers
  bool feed(std::uint8_t byte);

  /// What plays: the channels of all boards, one board after the other.
  ultrasound::Drive drive() const;
  bool sounds() const;     // any channel plays
  bool may_sound() const;  // or will, after a swap or with clocks on
  bool selected(std::size_t board) const { return boards_.at(board).selected; }
  bool clocks() const { return clocks_; }
  double modulation() const;  // Hz, of the tactile firmware; stock: 0
  std::size_t faults() const { return faults_; }

  /// Transducers of one board in channel order: 16 x 16, 10.5 mm apart, about the origin.
  static ultrasound::ArrayLayout layout();

 private:
  static constexpr std::size_t channels = 256;
  static constexpr std::uint8_t off = 32;

  struct Board {
    std::array<std::uint8_t, channels> front, back;
    std::size_t next = 0;
    bool selected = true;
  };
  void setNext(Board& board, std::uint8_t byte);

  std::vector<Board> boards_;
  bool tactile_;
  std::size_t first_;
  bool clocks_ = true;
  unsigned modulation_step_ = 10;
  std::size_t faults_ = 0;  // bytes that no board should be sent
};

}  // namespace tactile_clay::device
