#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace tactile_clay::device {

/// A small process that outlives its driver: it writes the bytes of silence to the port when the driver dies,
/// however it dies, or hangs. It waits on a pipe whose other end only the driver holds; the kernel closes
/// that end. It has a session of its own, so that what ends the driver's process group does not end it, and
/// holds no file of the driver but the port.
///
/// Each supervises the other: the guard answers every sign of life of the driver, and where it does not, the
/// driver has to be silent.
class SilenceGuard {
 public:
  enum class State { there, frozen, gone };

  /// Starts the process.
  /// @param port descriptor to write to
  /// @param silence what to write
  /// @param patience without a sign of life after which the driver, or the guard, counts as frozen
  /// @throws std::runtime_error where the system gives no process
  SilenceGuard(int port, const std::vector<std::uint8_t>& silence, std::chrono::milliseconds patience);

  /// Lets the process go. It writes the silence once more; one that is frozen is killed.
  ~SilenceGuard();
  SilenceGuard(const SilenceGuard&) = delete;
  SilenceGuard& operator=(const SilenceGuard&) = delete;

  /// A sign of life of the driver, to be given several times within the patience.
  /// @return how the guard is: frozen where a sign has had no answer for the patience
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
