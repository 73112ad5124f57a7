#include "tools/stop_input.h"

#include <fcntl.h>
#include <linux/input.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace tactile_clay::tools {
namespace {

constexpr char control_c = 3;
constexpr char reset_key = 'r';

/// Sets a terminal so that it gives each key at once, also Ctrl-C and Ctrl-Z: every key must be able to stop.
void makeRaw(int descriptor, const termios& before) {
  termios raw = before;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO | ISIG | IEXTEN);
  raw.c_iflag &= ~static_cast<tcflag_t>(IXON);
  ::tcsetattr(descriptor, TCSANOW, &raw);
}

}  // namespace

Keys::Keys(int descriptor) : descriptor_(descriptor) {
  termios settings{};
  if (::tcgetattr(descriptor_, &settings) != 0) return;
  before_ = settings;
  makeRaw(descriptor_, settings);
}

Keys::~Keys() {
  if (before_) ::tcsetattr(descriptor_, TCSANOW, &*before_);
}

Wish Keys::read() {
  char bytes[256];
  const ssize_t count = ::read(descriptor_, bytes, sizeof bytes);
  if (count < 0 && (errno == EINTR || errno == EAGAIN)) return Wish::none;
  if (count <= 0) return Wish::ended;
  if (terminal()) {
    if (std::find(bytes, bytes + count, control_c) != bytes + count) return Wish::stop_and_leave;
    // Keys such as the arrows come as several bytes: only input of nothing but `r` resets.
    return std::count(bytes, bytes + count, reset_key) == count ? Wish::reset : Wish::stop;
  }
  // If several lines come at once the last one counts, because they may be a stop and its reset.
  Wish wish = Wish::none;
  for (ssize_t i = 0; i < count; ++i) {
    if (bytes[i] != '\n') {
      line_ += bytes[i];
      continue;
    }
    wish = line_ == "r" || line_ == "reset" ? Wish::reset : Wish::stop;
    line_.clear();
  }
  return wish;
}

FootSwitch::FootSwitch(std::string path) : path_(std::move(path)) {
  open();
}

FootSwitch::~FootSwitch() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void FootSwitch::open() {
  struct stat there {};
  const bool fifo = ::stat(path_.c_str(), &there) == 0 && S_ISFIFO(there.st_mode);
  // A FIFO that is open for writing, too, does not end when its writers leave.
  descriptor_ = ::open(path_.c_str(), (fifo ? O_RDWR : O_RDONLY) | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (descriptor_ < 0)
    throw std::runtime_error("switch '" + path_ + "' cannot be opened: " + std::strerror(errno) +
                             "; expected an input device, a serial line, or a FIFO");
  int version = 0;
  keys_ = ::ioctl(descriptor_, EVIOCGVERSION, &version) == 0;
  if (keys_) {
    ::ioctl(descriptor_, EVIOCGRAB, 1);
    return;
  }
  termios settings{};
  if (::tcgetattr(descriptor_, &settings) != 0) return;
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  ::tcsetattr(descriptor_, TCSANOW, &settings);
}

bool FootSwitch::reopen() noexcept {
  try {
    if (descriptor_ < 0) open();
  } catch (const std::exception&) {
  }
  return descriptor_ >= 0;
}

Wish FootSwitch::read() {
  alignas(input_event) char bytes[64 * sizeof(input_event)];
  const ssize_t count = ::read(descriptor_, bytes, sizeof bytes);
  if (count < 0 && (errno == EINTR || errno == EAGAIN)) return Wish::none;
  if (count <= 0) {
    ::close(descriptor_);
    descriptor_ = -1;
    return Wish::stop;
  }
  if (!keys_) return Wish::stop;
  for (std::size_t at = 0; at + sizeof(input_event) <= static_cast<std::size_t>(count);
       at += sizeof(input_event)) {
    input_event event{};
    std::memcpy(&event, bytes + at, sizeof event);
    if (event.type == EV_KEY && event.value == 1) return Wish::stop;
  }
  return Wish::none;
}

}  // namespace tactile_clay::tools
