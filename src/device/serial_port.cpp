#include "device/serial_port.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <map>
#include <stdexcept>

namespace tactile_clay::device {
namespace {

speed_t speedOf(unsigned baud) {
  static const std::map<unsigned, speed_t> known = {{9600, B9600},     {19200, B19200},   {38400, B38400},
                                                    {57600, B57600},   {115200, B115200}, {230400, B230400},
                                                    {460800, B460800}, {921600, B921600}};
  const auto found = known.find(baud);
  if (found == known.end())
    throw std::runtime_error("serial port: " + std::to_string(baud) + " baud, expected a rate of termios");
  return found->second;
}

}  // namespace

SerialPort::SerialPort(const std::string& path, unsigned baud) : path_(path) {
  const speed_t speed = speedOf(baud);
  descriptor_ = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor_ < 0)
    throw std::runtime_error("serial port '" + path + "' cannot be opened: " + std::strerror(errno) +
                             "; expected the device file of a serial port");
  const auto give_up = [this](const std::string& line) {
    ::close(descriptor_);
    throw std::runtime_error("serial port '" + path_ + "' " + line);
  };
  termios settings{};
  if (::tcgetattr(descriptor_, &settings) != 0)
    give_up("is no terminal, expected the device file of a serial port");
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) give_up("is in use by another program");
  ::cfmakeraw(&settings);
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS | HUPCL);
  settings.c_cflag |= CLOCAL | CREAD;
  ::cfsetispeed(&settings, speed);
  ::cfsetospeed(&settings, speed);
  if (::tcsetattr(descriptor_, TCSANOW, &settings) != 0)
    give_up(std::string("cannot be set to ") + std::to_string(baud) + " baud: " + std::strerror(errno));
}

SerialPort::~SerialPort() {
  ::close(descriptor_);
}

bool SerialPort::pseudoTerminal() const {
  char name[64];
  return ::ttyname_r(descriptor_, name, sizeof name) == 0 && std::strncmp(name, "/dev/pts/", 9) == 0;
}

void SerialPort::fail(const std::string& what) const {
  throw std::runtime_error("serial port '" + path_ + "' " + what);
}

void SerialPort::check() const {
  pollfd state{descriptor_, POLLOUT, 0};
  if (::poll(&state, 1, 0) > 0 && (state.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0)
    fail("is gone: unplugged");
}

void SerialPort::write(const std::vector<std::uint8_t>& bytes, std::chrono::milliseconds patience) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t taken = ::write(descriptor_, bytes.data() + done, bytes.size() - done);
    if (taken > 0) {
      done += static_cast<std::size_t>(taken);
    } else if (taken < 0 && errno == EINTR) {
      continue;
    } else if (taken == 0 || errno == EAGAIN) {
      pollfd state{descriptor_, POLLOUT, 0};
      const int ready = ::poll(&state, 1, static_cast<int>(patience.count()));
      if (ready == 0) fail("takes no more bytes: the array does not read them");
      if (ready > 0 && (state.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) fail("is gone: unplugged");
    } else {
      fail(std::string("is gone: ") + std::strerror(errno));
    }
  }
}

void SerialPort::drop() noexcept {
  ::tcflush(descriptor_, TCOFLUSH);
}

std::size_t SerialPort::waiting() const {
  int bytes = 0;
  return ::ioctl(descriptor_, TIOCOUTQ, &bytes) == 0 && bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
}

}  // namespace tactile_clay::device
