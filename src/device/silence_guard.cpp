#include "device/silence_guard.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <string>
#include <thread>

#include "safety/silence_times.h"

namespace tactile_clay::device {
namespace {

using namespace std::chrono_literals;

constexpr auto longest_write = static_cast<int>(silence_times::guard_port_patience.count());  // ms

// From here to guardProcess: only calls that are safe after fork() in a program with several threads.

void writeAll(int port, const std::uint8_t* bytes, std::size_t count) {
  // Bytes that the driver left in the port would delay the silence. The silence starts a frame of its own, so
  // the old frame may be cut.
  ::tcflush(port, TCOFLUSH);
  while (count > 0) {
    const ssize_t taken = ::write(port, bytes, count);
    if (taken > 0) {
      bytes += taken;
      count -= static_cast<std::size_t>(taken);
    } else if (taken < 0 && errno == EINTR) {
      continue;
    } else if (taken == 0 || errno == EAGAIN) {
      pollfd state{port, POLLOUT, 0};
      if (::poll(&state, 1, longest_write) <= 0 || (state.revents & (POLLHUP | POLLERR)) != 0) return;
    } else {
      return;
    }
  }
}

[[noreturn]] void guardProcess(int port, int pipe, const std::uint8_t* silence, std::size_t size,
                               int patience, int max_descriptors) {
  ::setsid();
  for (const int ignored : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGQUIT}) ::signal(ignored, SIG_IGN);
  ::prctl(PR_SET_NAME, "silence_guard");
  for (int other = 3; other < max_descriptors; ++other)
    if (other != port && other != pipe) ::close(other);
  for (int standard = 0; standard < 3; ++standard)
    if (standard != port && standard != pipe) ::close(standard);
  bool silenced = false;
  while (true) {
    pollfd state{pipe, POLLIN, 0};
    const int ready = ::poll(&state, 1, silenced ? -1 : patience);
    if (ready < 0) continue;
    if (ready == 0) {  // the driver hangs
      writeAll(port, silence, size);
      silenced = true;
      continue;
    }
    std::uint8_t signs[64];
    const ssize_t count = ::read(pipe, signs, sizeof signs);
    if (count > 0) {
      silenced = false;
      ::send(pipe, signs, 1, MSG_NOSIGNAL | MSG_DONTWAIT);
    } else if (count == 0) {  // the driver is dead
      writeAll(port, silence, size);
      ::_exit(0);
    }
  }
}

}  // namespace

SilenceGuard::SilenceGuard(int port, const std::vector<std::uint8_t>& silence,
                           std::chrono::milliseconds patience)
    : patience_(patience) {
  int ends[2];
  // A socket pair, because a write to it can be asked not to raise SIGPIPE.
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw std::runtime_error(std::string("silence guard: no pipe: ") + std::strerror(errno));
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  const int maximum = static_cast<int>(limit.rlim_cur < 65536 ? limit.rlim_cur : 65536);
  process_ = ::fork();
  if (process_ == 0)
    guardProcess(port, ends[1], silence.data(), silence.size(), static_cast<int>(patience.count()), maximum);
  const int error = errno;
  ::close(ends[1]);
  pipe_ = ends[0];
  if (process_ < 0) {
    ::close(pipe_);
    throw std::runtime_error(std::string("silence guard: no process: ") + std::strerror(error));
  }
}

SilenceGuard::~SilenceGuard() {
  ::close(pipe_);
  const auto until =
      Clock::now() + (state_ == State::frozen ? 0ms : silence_times::guard_port_patience + patience_);
  while (::waitpid(process_, nullptr, WNOHANG) == 0) {
    if (Clock::now() > until) ::kill(process_, SIGKILL);
    std::this_thread::sleep_for(1ms);
  }
}

SilenceGuard::State SilenceGuard::beat() noexcept {
  if (state_ == State::gone) return state_;
  const auto now = Clock::now();
  std::uint8_t answers[64];
  ssize_t count = 0;
  while ((count = ::recv(pipe_, answers, sizeof answers, MSG_DONTWAIT)) > 0) unanswered_.reset();
  const std::uint8_t sign = 1;
  const bool broken =
      count == 0 || (::send(pipe_, &sign, 1, MSG_NOSIGNAL | MSG_DONTWAIT) != 1 && errno != EAGAIN);
  // The time counts from the first sign without an answer, not from the last answer: after the driver itself
  // was stopped, the guard has answered all of its signs.
  if (!unanswered_) unanswered_ = now;
  state_ = broken ? State::gone : now - *unanswered_ > patience_ ? State::frozen : State::there;
  return state_;
}

}  // namespace tactile_clay::device
