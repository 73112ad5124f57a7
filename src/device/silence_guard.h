#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace tactile_clay::device {

/// A small process that outlives its driver. It writes the bytes of silence to the port when the driver hangs
/// or dies for any reason. It waits on a pipe; only the driver has the other end open, and the kernel closes
/// that end when the driver dies. The guard has a session of its own, so a signal that ends the driver's
/// process group does not end it. The port is the only file of the driver that it keeps open.
///
/// Driver and guard supervise each other: the guard answers every sign of life of the driver. If it does not
/// answer, the driver has to be silent.
class SilenceGuard {
 public:
  enum class State { there, frozen, gone };

  /// Starts the process.
  /// @param port descriptor to write to
  /// @param silence bytes to write
  /// @param patience time without a sign of life after which the driver, or the guard, counts as frozen
  /// @throws std::runtime_error if the system cannot start a process
  SilenceGuard(int port, const std::vector<std::uint8_t>& silence, std::chrono::milliseconds patience);

  /// Closes the pipe: the process writes the silence once more and ends. If it is frozen or too slow, it is
  /// killed.
  ~SilenceGuard();
  SilenceGuard(const SilenceGuard&) = delete;
  SilenceGuard& operator=(const SilenceGuard&) = delete;

  /// Sends a sign of life of the driver; to be called several times within the patience.
  /// @return state of the guard: frozen if a sign had no answer for the patience
  State beat() noexcept;

  pid_t process() const { return process_; }

 private:
  using Clock = std::chrono::steady_clock;

  int pipe_ = -1;
  pid_t process_ = -1;
  std::chrono::milliseconds patience_;
  std::optional<Clock::time_point> unanswered_;  // the first sign that has no answer yet
  State state_ = State::there;
};

}  // namespace tactile_clay::device
