#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <vector>

namespace tactile_clay::device {

/// A small process that outlives its driver: it writes the bytes of silence to the port when the driver dies,
/// however it dies, or hangs. It waits on a pipe whose other end only the driver holds; the kernel closes
/// that end. It has a session of its own, so that what ends the driver's process group does not end it, and
/// holds no file of the driver but the port.
class SilenceGuard {
 public:
  /// Starts the process.
  /// \param port descriptor to write to
  /// \param silence what to write
  /// \param patience without a sign of life after which the driver counts as hung
  /// \throws std::runtime_error where the system gives no process
  SilenceGuard(int port, const std::vector<std::uint8_t>& silence, std::chrono::milliseconds patience);

  /// Lets the process go. It writes the silence once more.
  ~SilenceGuard();
  SilenceGuard(const SilenceGuard&) = delete;
  SilenceGuard& operator=(const SilenceGuard&) = delete;

  /// A sign of life of the driver. \return false where the guard is gone
  bool alive() noexcept;

 private:
  int pipe_ = -1;
  pid_t process_ = -1;
};

}  // namespace tactile_clay::device
