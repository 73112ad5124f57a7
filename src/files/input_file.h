#pragma once

#include <cstdint>
#include <string>

struct gzFile_s;

namespace tactile_clay::files {

/// The way in for every file that somebody names. Only a regular file that is not empty and has at most so
/// many bytes is opened: a FIFO would hold its reader for ever, a device would be changed by being opened.
/// Nothing here waits. Every error is a std::runtime_error with one line "FILE: what was found, what was
/// expected".

constexpr std::uint64_t mebibyte = 1ULL << 20U, gibibyte = 1ULL << 30U;

/// Maximum bytes of files, by what they hold. Each is ten times or more what anybody has sent so far.
namespace maximum {
constexpr std::uint64_t text = 16 * mebibyte;        // scenes, materials, scores, URDF
constexpr std::uint64_t recording = 64 * gibibyte;   // is read one frame at a time
constexpr std::uint64_t whole_recording = gibibyte;  // is held in memory, uncompressed
constexpr std::uint64_t sculpture = 4 * gibibyte;    // 60 bytes a particle, 16 a bond
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
/// @param max_bytes that it may have
Descriptor openInput(const std::string& file, std::uint64_t max_bytes);

/// For libraries that open files by their names.
/// @throws std::runtime_error where openInput would
void requireInput(const std::string& file, std::uint64_t max_bytes);

/// All of a file.
std::string readWhole(const std::string& file, std::uint64_t max_bytes);

/// All of a file, unpacked where it is gzipped.
/// @param max_bytes before and after
std::string readUnpacked(const std::string& file, std::uint64_t max_bytes);

/// Closes a file of zlib, in a std::unique_ptr.
struct CloseGzip {
  void operator()(gzFile_s* file) const;
};

/// Opens a file, gzipped or not, for zlib.
/// @return what gzclose closes
gzFile_s* openGzip(const std::string& file, std::uint64_t max_bytes);

}  // namespace tactile_clay::files
