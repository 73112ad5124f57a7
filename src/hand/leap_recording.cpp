#include "hand/leap_recording.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "files/input_file.h"
#include "hand/leap_json.h"

namespace tactile_clay::hand {
namespace {

constexpr std::size_t longest_line = leap::Limits().bytes;
// Between two frames: a gz of newlines unpacks to a thousand times its size, and would hold its reader as
// long.
constexpr int most_lines = 10'000;
constexpr std::size_t most_bytes = 16U << 20U;

}  // namespace

void LeapRecording::fail(const std::string& what) const {
  throw std::runtime_error("recording '" + path_ + "': " + what +
                           ", expected a file of Leap v6 JSON frames, one a line, plain or gzipped");
}

void LeapRecording::open(const SourceOptions& options) {
  *this = LeapRecording();
  path_ = options.file;
  loop_ = options.loop;
  if (path_.empty()) fail("no file is given");
  try {
    file_.reset(files::openGzip(path_, files::most::recording));
  } catch (const std::runtime_error& error) {
    fail(std::string(error.what()).substr(path_.size() + 2));
  }
  gzbuffer(file_.get(), 1U << 17U);
  first_ = nextFrame();
  if (!first_) fail("holds no frame");
}

bool LeapRecording::readLine(std::string& line) {
  line.clear();
  std::array<char, 16384> part;
  while (gzgets(file_.get(), part.data(), static_cast<int>(part.size())) != nullptr) {
    if (part[0] == '\0') fail("line " + std::to_string(line_ + 1) + " is not text");
    line += part.data();
    if (line.back() == '\n') break;
    if (line.size() > longest_line)
      fail("line " + std::to_string(line_ + 1) + " is longer than " + std::to_string(longest_line) +
           " bytes");
  }
  int code = Z_OK;
  const char* message = gzerror(file_.get(), &code);
  if (code != Z_OK && code != Z_STREAM_END)
    fail("cannot be read after line " + std::to_string(line_) + ": " +
         (code == Z_ERRNO ? std::strerror(errno) : message));
  if (line.empty()) return false;
  ++line_;
  return true;
}

std::optional<LeapFrame> LeapRecording::nextFrame() {
  std::string line;
  std::size_t bytes = 0;
  for (int lines = 0; readLine(line); ++lines) {
    bytes += line.size();
    if (lines > most_lines || bytes > most_bytes)
      fail("no frame in " + std::to_string(lines) + " lines and " + std::to_string(bytes) +
           " bytes up to line " + std::to_string(line_));
    auto frame = parseLeapFrame(line, path_ + ":" + std::to_string(line_));
    if (!frame) continue;
    dropped_hands_ += frame->dropped.size();
    if (!frame->dropped.empty()) last_drop_ = new_drop_ = frame->dropped.back();
    frame->frame.stamp = stamps_(frame->frame.stamp);
    return frame;
  }
  return std::nullopt;
}

void LeapRecording::rewind() {
  stamps_.rewind();
  line_ = 0;
  if (gzrewind(file_.get()) != 0) fail("cannot be rewound");
}

HandSource::Read LeapRecording::read(TrackedFrame& frame, std::chrono::milliseconds /*timeout*/) {
  if (!file_) return Read::ended;
  std::optional<LeapFrame> next = std::move(first_);
  first_.reset();
  if (!next) next = nextFrame();
  if (!next && loop_) {
    rewind();
    next = nextFrame();
  }
  if (!next) {
    file_.reset();
    return Read::ended;
  }
  frame = std::move(next->frame);
  return Read::frame;
}

}  // namespace tactile_clay::hand
