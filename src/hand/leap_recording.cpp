#include "hand/leap_recording.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "files/input_file.h"
#include "hand/leap_json.h"
#include "values/text.h"

namespace tactile_clay::hand {
namespace {

constexpr std::size_t longest_line = leap::Limits().bytes;
// Limits between two frames: a gzipped file of newlines unpacks to a thousand times its size, and would block
// its reader for as long.
constexpr int max_lines = 10'000;
constexpr std::size_t max_bytes = 16U << 20U;
// Bytes; the recorders write 20 MB per minute for two hands.
constexpr std::size_t longest_leapjs = 256U << 20U;
constexpr std::size_t beginning = 64U << 10U;  // bytes from which the format is recognised
// Limits of the search for a hand with bones: 10 s or more of a recording, but not more of any other file.
constexpr int frames_without_bones = 600;
constexpr z_off_t bytes_without_bones = 64U << 20U;
// Median of the intervals between the first frames, s, and how many are needed for it. Trackers have 10 to
// 200 Hz.
constexpr int timed_frames = 100;
constexpr double shortest_interval = 0.001, longest_interval = 0.5;
constexpr std::size_t fewest_intervals = 10;

}  // namespace

void LeapRecording::fail(const std::string& what) const {
  throw std::runtime_error(
      "recording '" + path_ + "': " + what +
      ", expected a file of Leap v6 JSON frames, one a line or as leapjs-playback saves them, plain "
      "or gzipped");
}

void LeapRecording::open(const SourceOptions& options) {
  *this = LeapRecording();
  path_ = options.file;
  loop_ = options.loop;
  if (path_.empty()) fail("no file is given");
  toBegin();
  openLeapjs();
  requireBones();
  startAnew();
  requireMicroseconds();
  startAnew();
  first_ = nextFrame();
  if (!first_) fail("holds no frame");
}

void LeapRecording::toBegin() {
  try {
    file_.reset(files::openGzip(path_, files::maximum::recording));
  } catch (const std::runtime_error& error) {
    fail(std::string(error.what()).substr(path_.size() + 2));
  }
  gzbuffer(file_.get(), 1U << 17U);
  line_ = 0;
}

void LeapRecording::openLeapjs() {
  std::string text(beginning, '\0');
  const auto read = [&](std::size_t from) {
    const int got = gzread(file_.get(), &text[from], static_cast<unsigned>(text.size() - from));
    text.resize(from + static_cast<std::size_t>(std::max(got, 0)));
    return got > 0;
  };
  read(0);
  if (LeapjsRecording::isOne(text)) {
    for (std::size_t size = text.size(); text.size() <= longest_leapjs; size = text.size()) {
      text.resize(size + beginning);
      if (!read(size)) break;
    }
    try {
      leapjs_.emplace(std::move(text), longest_leapjs);
    } catch (const std::runtime_error& error) {
      fail(error.what());
    }
  }
  toBegin();
}

// Reported at once, not hand by hand while the rig runs.
void LeapRecording::requireBones() {
  bool boneless = false;
  try {
    for (int i = 0; i < frames_without_bones && gztell(file_.get()) < bytes_without_bones && !boneless; ++i) {
      const auto frame = nextFrame();
      if (!frame || !frame->frame.hands.empty()) break;
      boneless = frame->without_bones;
    }
  } catch (const std::runtime_error&) {
    // The error is reported where the frame is read.
  }
  if (boneless)
    fail("its fingers have no bones, as in Leap's " +
         (protocol_ ? "protocol " + std::to_string(*protocol_) : std::string("protocols 1 to 4")));
}

// A recording in milliseconds would be over in no time, and one in nanoseconds would seem to hang.
void LeapRecording::requireMicroseconds() {
  std::vector<double> intervals;  // s
  try {
    std::optional<std::chrono::nanoseconds> last;
    for (int i = 0; i < timed_frames && gztell(file_.get()) < bytes_without_bones; ++i) {
      const auto frame = nextFrame();
      if (!frame) break;
      const std::chrono::nanoseconds stamp = frame->frame.stamp;
      if (last && stamp > *last) intervals.push_back(std::chrono::duration<double>(stamp - *last).count());
      last = stamp;
    }
  } catch (const std::runtime_error&) {
    // The error is reported where the frame is read.
  }
  if (intervals.size() < fewest_intervals) return;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  if (*middle < shortest_interval || *middle > longest_interval)
    fail("its frames are " + values::text(1e3 * *middle) +
         " ms apart, expected 1 to 500 ms (timestamps are in microseconds)");
}

void LeapRecording::startAnew() {
  toBegin();
  stamps_ = {};
  dropped_hands_ = 0;
  last_drop_.clear();
  new_drop_.clear();
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

bool LeapRecording::readMessage(std::string& message, std::string& where) {
  if (!leapjs_) {
    const bool read = readLine(message);
    where = path_ + ":" + std::to_string(line_);
    return read;
  }
  if (line_ == leapjs_->frames()) return false;
  where = path_ + ": frame " + std::to_string(++line_);
  try {
    message = leapjs_->frame(line_ - 1);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(where + " " + error.what());
  }
  return true;
}

std::optional<LeapFrame> LeapRecording::nextFrame() {
  std::string message, where;
  std::size_t bytes = 0;
  for (int lines = 0; readMessage(message, where); ++lines) {
    bytes += message.size();
    if (lines > max_lines || bytes > max_bytes)
      fail("no frame in " + std::to_string(lines) + " lines and " + std::to_string(bytes) +
           " bytes up to line " + std::to_string(line_));
    auto frame = parseLeapFrame(message, where);
    if (!frame) {
      if (const auto version = parseLeapVersion(message)) protocol_ = version;
      continue;
    }
    dropped_hands_ += frame->dropped.size();
    if (!frame->dropped.empty()) last_drop_ = new_drop_ = frame->dropped.back();
    frame->frame.stamp = stamps_(frame->frame.stamp);
    return frame;
  }
  return std::nullopt;
}

void LeapRecording::rewind() {
  stamps_.rewind();
  toBegin();
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
