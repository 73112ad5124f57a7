#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "files/input_file.h"
#include "hand/hand_source.h"
#include "hand/leap_frame.h"
#include "hand/loop_stamps.h"

namespace tactile_clay::hand {

/// A recording of Leap v6 messages, one JSON a line, plain or gzipped (`leapd`'s websocket written to a
/// file). Streams: holds one line in memory. Looped, its clock goes on by the mean frame time from the last
/// to the first.
class LeapRecording : public HandSource {
 public:
  /// \throws std::runtime_error if `options.file` cannot be read or holds no frame at all
  void open(const SourceOptions& options) override;

  /// Does not wait. \throws std::runtime_error for a line that is no Leap message, with file and line
  Read read(TrackedFrame& frame, std::chrono::milliseconds timeout) override;

  bool recorded() const override { return true; }

  /// The newest hand that had to be left out.
  std::string takeFault() override { return std::exchange(new_drop_, {}); }

  std::uint64_t droppedHands() const { return dropped_hands_; }
  const std::string& lastDrop() const { return last_drop_; }  // one line, empty while there was none

 private:
  bool readLine(std::string& line);
  std::optional<LeapFrame> nextFrame();
  void rewind();
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  std::unique_ptr<gzFile_s, files::CloseGzip> file_;
  bool loop_ = false;
  std::uint64_t line_ = 0;
  std::optional<LeapFrame> first_;  // read by open, not yet handed out

  LoopStamps stamps_;

  std::uint64_t dropped_hands_ = 0;
  std::string last_drop_, new_drop_;
};

}  // namespace tactile_clay::hand
