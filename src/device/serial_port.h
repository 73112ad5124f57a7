#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace tactile_clay::device {

/// A serial port opened for writing, 8N1 without flow control, locked against other programs that use flock.
/// The destructor closes it.
class SerialPort {
 public:
  /// @param baud one of the rates that termios knows
  /// @throws std::runtime_error with one line if the port cannot be opened, is no terminal, or is in use
  SerialPort(const std::string& path, unsigned baud);
  ~SerialPort();
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  /// Writes all bytes to the port.
  /// @throws std::runtime_error with one line if the port is gone, or takes no byte for `patience`
  void write(const std::vector<std::uint8_t>& bytes, std::chrono::milliseconds patience);

  /// Bytes that still wait in the port; 0 if the port does not know.
  std::size_t waiting() const;

  /// Removes the bytes that still wait.
  void drop() noexcept;

  /// @throws std::runtime_error with one line if the port is gone
  void check() const;

  /// Whether the port is the end of a pseudo-terminal (pty(7)), and so no hardware of this computer.
  bool pseudoTerminal() const;

  int descriptor() const { return descriptor_; }

 private:
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  int descriptor_ = -1;
};

}  // namespace tactile_clay::device
