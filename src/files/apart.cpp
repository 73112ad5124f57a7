#include "files/apart.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <new>
#include <optional>
#include <stdexcept>

namespace tactile_clay::files {
namespace {

// First byte of the answer of the separate process.
constexpr char done = 'd', failed = 'f';

std::string tooLong(const Bounds& bounds) {
  return "takes its reader more than " + std::to_string(bounds.time.count()) + " s, expected less";
}
std::string tooLarge(const Bounds& bounds) {
  return "takes its reader more than " + std::to_string(bounds.memory / mebibyte) +
         " MiB of memory, expected less";
}

void limit(int what, rlim_t maximum) {
  const rlimit both{maximum, maximum};
  ::setrlimit(static_cast<__rlimit_resource>(what), &both);
}

/// The whole run of the separate process. It never returns, so this process cannot go on with the work of its
/// parent.
[[noreturn]] void workApart(const std::function<std::string()>& work, const Bounds& bounds, int to) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL})
    ::signal(signal, SIG_DFL);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, static_cast<rlim_t>(bounds.time.count()));
#ifndef __SANITIZE_ADDRESS__  // the address sanitizer maps terabytes
  std::ifstream statm("/proc/self/statm");
  rlim_t pages = 0;  // that the process has already
  if (statm >> pages) limit(RLIMIT_AS, pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + bounds.memory);
#endif
  std::string said;
  try {
    said = done + work();
  } catch (const std::bad_alloc&) {
    said = failed + tooLarge(bounds);
  } catch (const std::exception& error) {
    said = failed + std::string(error.what());
  }
  std::size_t at = 0;
  while (at < said.size()) {
    const ssize_t count = ::write(to, said.data() + at, said.size() - at);
    if (count < 0 && errno != EINTR) ::_exit(1);
    if (count > 0) at += static_cast<std::size_t>(count);
  }
  ::_exit(0);
}

/// All bytes from a pipe until it is closed; nothing if it is not closed in time.
std::optional<std::string> listen(int from, std::chrono::steady_clock::time_point end) {
  std::string all;
  char buffer[1 << 16];
  while (true) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now()).count();
    if (left <= 0) return std::nullopt;
    pollfd waiting{from, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, static_cast<int>(left));
    if (ready <= 0) continue;  // the time is up, or a signal came
    const ssize_t count = ::read(from, buffer, sizeof buffer);
    if (count == 0) return all;
    if (count > 0) all.append(buffer, static_cast<std::size_t>(count));
  }
}

}  // namespace

std::string runApart(const std::function<std::string()>& work, const Bounds& bounds) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    throw std::runtime_error(std::string("no pipe: ") + std::strerror(errno));
  const Descriptor from(ends[0]);
  Descriptor to(ends[1]);
  const pid_t process = ::fork();
  if (process < 0)
    throw std::runtime_error(std::string("no process for its reader: ") + std::strerror(errno));
  if (process == 0) workApart(work, bounds, to.get());
  to = Descriptor();  // so that the pipe is closed when the process ends
  const std::optional<std::string> said =
      listen(from.get(), std::chrono::steady_clock::now() + 2 * bounds.time);
  if (!said) ::kill(process, SIGKILL);
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  if (!said || (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)))
    throw std::runtime_error(tooLong(bounds));
  if (WIFSIGNALED(status))
    throw std::runtime_error(std::string("crashes its reader (") + ::strsignal(WTERMSIG(status)) +
                             "), expected a sound file");
  if (said->empty()) throw std::runtime_error("ends its reader, expected a sound file");
  if (said->front() == failed) throw std::runtime_error(said->substr(1));
  return said->substr(1);
}

}  // namespace tactile_clay::files
