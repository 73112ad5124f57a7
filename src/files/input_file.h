#pragma once

#include <cstdint>
#include <optional>
#include <string>

struct gzFile_s;

namespace tactile_clay::files {

/// Opens every file that a user names. Only a regular file is opened that is not empty and not larger than a
/// maximum: a FIFO would block its reader for ever, and opening alone changes some devices. Nothing here
/// waits. Every error is a std::runtime_error with one line "FILE: what was found, what was expected".

constexpr std::uint64_t mebibyte = 1ULL << 20U, gibibyte = 1ULL << 30U;

/// Maximum sizes of files in bytes, by their content. Each is at least ten times as large as any file that
/// was sent so far.
namespace maximum {
constexpr std::uint64_t text = 16 * mebibyte;        // scenes, materials, scores, URDF
constexpr std::uint64_t recording = 64 * gibibyte;   // is read one frame at a time
constexpr std::uint64_t whole_recording = gibibyte;  // is kept in memory, uncompressed
constexpr std::uint64_t sculpture = gibibyte;        // 60 bytes per particle, 16 per bond
}  // namespace maximum

/// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(other.release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor();

  int get() const { return fd_; }
  int release();

 private:
  int fd_;
};

/// Opens a file for reading.
/// @param max_bytes maximum size
Descriptor openInput(const std::string& file, std::uint64_t max_bytes);

/// Checks a file that a library will open by its name.
/// @throws std::runtime_error if openInput would throw it
void requireInput(const std::string& file, std::uint64_t max_bytes);

/// The whole content of a file.
std::string readWhole(const std::string& file, std::uint64_t max_bytes);

/// The whole content of a file that begins with a text.
/// @return nothing if the file begins differently; then the rest of it is not read
std::optional<std::string> readWholeWith(const std::string& beginning, const std::string& file,
                                         std::uint64_t max_bytes);

/// The whole content of a file, unpacked if it is gzipped.
/// @param max_bytes maximum size before and after unpacking
std::string readUnpacked(const std::string& file, std::uint64_t max_bytes);

/// Closes a file of zlib; a deleter for std::unique_ptr.
struct CloseGzip {
  void operator()(gzFile_s* file) const;
};

/// Opens a file, gzipped or not, for zlib.
/// @return the file, to be closed by gzclose
gzFile_s* openGzip(const std::string& file, std::uint64_t max_bytes);

}  // namespace tactile_clay::files
