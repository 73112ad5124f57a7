#include "files/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <utility>

namespace tactile_clay::files {
namespace {

constexpr std::size_t chunk = 1U << 16U;  // bytes read at a time

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw std::runtime_error(file + ": " + what);
}

std::string kind(mode_t mode) {
  if (S_ISDIR(mode)) return "is a folder";
  if (S_ISFIFO(mode)) return "is a FIFO";
  if (S_ISSOCK(mode)) return "is a socket";
  return "is a device";
}

void requireGood(const std::string& file, const struct stat& status, std::uint64_t max_bytes) {
  if (!S_ISREG(status.st_mode)) fail(file, kind(status.st_mode) + ", expected a regular file");
  if (status.st_size == 0) fail(file, "is empty, expected a file with something in it");
  if (static_cast<std::uint64_t>(status.st_size) > max_bytes)
    fail(file,
         "has " + std::to_string(status.st_size) + " bytes, expected at most " + std::to_string(max_bytes));
}

}  // namespace

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

Descriptor::~Descriptor() {
  if (fd_ >= 0) ::close(fd_);
}

int Descriptor::release() {
  return std::exchange(fd_, -1);
}

Descriptor openInput(const std::string& file, std::uint64_t max_bytes) {
  if (file.find('\0') != std::string::npos)
    // The part of the name that can be printed.
    fail(file.substr(0, file.find('\0')), "is a name with a zero in it, expected none");
  struct stat status {};
  // Checks by name first, because opening alone changes some devices, such as the lines of a serial port.
  if (::stat(file.c_str(), &status) != 0)
    fail(file, std::string("cannot be opened (") + std::strerror(errno) + "), expected a readable file");
  requireGood(file, status, max_bytes);
  Descriptor opened(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (opened.get() < 0)
    fail(file, std::string("cannot be opened (") + std::strerror(errno) + "), expected a readable file");
  // Another file may have taken the name in the meantime.
  if (::fstat(opened.get(), &status) != 0) fail(file, std::strerror(errno));
  requireGood(file, status, max_bytes);
  return opened;
}

void requireInput(const std::string& file, std::uint64_t max_bytes) {
  openInput(file, max_bytes);
}

std::string readWhole(const std::string& file, std::uint64_t max_bytes) {
  return *readWholeWith("", file, max_bytes);  // every file begins with nothing
}

std::optional<std::string> readWholeWith(const std::string& beginning, const std::string& file,
                                         std::uint64_t max_bytes) {
  const Descriptor opened = openInput(file, max_bytes);
  std::string text;
  while (true) {
    const std::size_t before = text.size();
    text.resize(before + chunk);
    const ssize_t got = ::read(opened.get(), &text[before], chunk);
    text.resize(before + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(file, std::string("cannot be read: ") + std::strerror(errno));
    if (text.size() > max_bytes)
      fail(file, "has more than " + std::to_string(max_bytes) + " bytes, expected at most as many");
    const bool enough = got == 0 || text.size() >= beginning.size();
    if (enough && text.compare(0, beginning.size(), beginning) != 0) return std::nullopt;
    if (got == 0) return text;
  }
}

std::string readUnpacked(const std::string& file, std::uint64_t max_bytes) {
  const std::unique_ptr<gzFile_s, CloseGzip> opened(openGzip(file, max_bytes));
  std::string text;
  while (true) {
    const std::size_t before = text.size();
    text.resize(before + chunk);
    const int got = gzread(opened.get(), &text[before], chunk);
    text.resize(before + static_cast<std::size_t>(std::max(got, 0)));
    int code = Z_OK;
    const char* message = gzerror(opened.get(), &code);
    if (got < 0 || (got == 0 && code != Z_OK && code != Z_STREAM_END))
      fail(file, std::string("cannot be unpacked: ") + (code == Z_ERRNO ? std::strerror(errno) : message));
    if (text.size() > max_bytes)
      fail(file, "unpacks to more than " + std::to_string(max_bytes) + " bytes, expected at most as many");
    if (got == 0) return text;
  }
}

void CloseGzip::operator()(gzFile_s* file) const {
  gzclose_r(file);
}

gzFile_s* openGzip(const std::string& file, std::uint64_t max_bytes) {
  Descriptor opened = openInput(file, max_bytes);
  gzFile_s* const unpacked = gzdopen(opened.get(), "rb");
  if (unpacked == nullptr) fail(file, "cannot be opened, for there is no memory");
  opened.release();  // gzclose closes it
  return unpacked;
}

}  // namespace tactile_clay::files
