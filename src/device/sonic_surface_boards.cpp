#include "device/sonic_surface_boards.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace tactile_clay::device {

SonicSurfaceBoards::SonicSurfaceBoards(std::size_t boards, bool tactile, std::size_t first)
    : boards_(boards), tactile_(tactile), first_(first) {
  if (boards < 1 || boards > (tactile ? 1u : 2u))
    throw std::invalid_argument("SonicSurface: " + std::to_string(boards) +
                                " boards, expected 1, or 2 with the stock firmware");
  for (std::size_t b = 0; b < boards; ++b) {
    boards_[b].front.fill(off);
    boards_[b].back.fill(off);
  }
}

void SonicSurfaceBoards::setNext(Board& board, std::uint8_t byte) {
  if (byte > off || board.next >= channels) ++faults_;
  board.back[board.next++ % channels] = byte == off ? off : static_cast<std::uint8_t>(byte & 0x1F);
}

bool SonicSurfaceBoards::feed(std::uint8_t byte) {
  if (byte == 0xFD) {
    for (Board& board : boards_) {
      std::swap(board.front, board.back);
      board.next = 0;
    }
    return true;
  }
  if (tactile_ && (byte & 0xE0) == 0xA0) {
    modulation_step_ = byte & 0x1F;
  } else if (!tactile_ && (byte == 0xC0 || byte == 0xC1)) {
    for (std::size_t b = 0; b < boards_.size(); ++b) boards_[b].selected = b + first_ == byte - 0xC0u;
  } else if (!tactile_ && (byte == 150 || byte == 151)) {
    clocks_ = byte == 151;
  } else {
    for (Board& board : boards_) {
      if (!board.selected) continue;
      if (byte == 0xFE)
        board.next = 0;
      else
        setNext(board, byte);
    }
  }
  return false;
}

ultrasound::Drive SonicSurfaceBoards::drive() const {
  ultrasound::Drive drive;
  for (const Board& board : boards_) {
    for (const std::uint8_t value : board.front) {
      const int level = tactile_ ? value & 0x1E : value;  // the firmware ignores the lowest bit
      drive.phase.push_back(value == off ? 0.0f : static_cast<float>(level * (2.0 * M_PI / 32.0)));
      drive.amplitude.push_back(value == off || !clocks_ ? 0.0f : 1.0f);
    }
  }
  return drive;
}

bool SonicSurfaceBoards::sounds() const {
  return clocks_ && std::any_of(boards_.begin(), boards_.end(), [](const Board& board) {
           return std::any_of(board.front.begin(), board.front.end(),
                              [](auto value) { return value != off; });
         });
}

bool SonicSurfaceBoards::may_sound() const {
  const auto sounds = [](const auto& buffer) {
    return std::any_of(buffer.begin(), buffer.end(), [](auto value) { return value != off; });
  };
  return std::any_of(boards_.begin(), boards_.end(),
                     [&](const Board& board) { return sounds(board.front) || sounds(board.back); });
}

double SonicSurfaceBoards::modulation() const {
  return tactile_ ? 1250.0 / (modulation_step_ + 1) : 0.0;
}

ultrasound::ArrayLayout SonicSurfaceBoards::layout() {
  // Channels of the four columns and two rows that one shift register serves. The registers follow each other
  // down a strip of four columns, then strip by strip.
  constexpr std::size_t side = 16;
  constexpr std::size_t registers[2][4] = {{0, 7, 1, 2}, {4, 3, 6, 5}};
  ultrasound::ArrayLayout layout;
  layout.name = "sonic_surface";
  layout.pitch = 0.0105;
  layout.position.resize(channels);
  layout.normal.assign(channels, Eigen::Vector3d::UnitZ());
  for (std::size_t down = 0; down < side; ++down) {
    for (std::size_t column = 0; column < side; ++column) {
      const std::size_t channel = column / 4 * 64 + down / 2 * 8 + registers[down % 2][column % 4];
      layout.position[channel] = {(static_cast<double>(column) - 7.5) * layout.pitch,
                                  (7.5 - static_cast<double>(down)) * layout.pitch, 0.0};
    }
  }
  return layout;
}

}  // namespace tactile_clay::device
