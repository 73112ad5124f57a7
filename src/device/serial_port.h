#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace tactile_clay::device {

/// A serial port opened for writing, 8N1 without flow control, locked against other programs that use flock.
/// Closes itself.
class SerialPort {
 public:
  /// @param baud one of the rates that termios knows
  /// @throws std::runtime_error with one line where the port cannot be opened, is no terminal, or is in use
  SerialPort(const std::string& path, unsigned baud);
  ~SerialPort();
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  /// Hands all bytes to the port.
  /// @throws std::runtime_error with one line where it is gone or takes none for `patience`
  void write(const std::vector<std::uint8_t>& bytes, std::chrono::milliseconds patience);

  /// Bytes that still wait in the port; 0 where it cannot tell.
  std::size_t waiting() const;

  /// Drops them.
  void drop() noexcept;

  /// @throws std::runtime_error with one line where the port is gone
  void check() const;

  /// Whether it is the end of a pseudo-terminal (pty(7)), and so no port of this computer.
  bool pseudoTerminal() const;

  int descriptor() const { return descriptor_; }

 private:
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  int descriptor_ = -1;
};

}  // namespace tactile_clay::device
