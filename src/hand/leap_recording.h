#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "files/input_file.h"
#include "hand/hand_source.h"
#include "hand/leap_frame.h"
#include "hand/leapjs_recording.h"
#include "hand/loop_stamps.h"

namespace tactile_clay::hand {

/// A recording of Leap v6 messages: one JSON per line (`leapd`'s websocket written to a file), or as
/// leapjs-playback saves it (leapjs_recording.h), plain or gzipped. Lines are streamed: only one is in
/// memory. In a loop the clock goes on by the mean frame time from the last frame to the first.
class LeapRecording : public HandSource {
 public:
  /// @throws std::runtime_error if `options.file` cannot be read, contains no frame at all, or is of a
  /// protocol whose hands have no bones
  void open(const SourceOptions& options) override;

  /// Does not wait.
  /// @throws std::runtime_error for a line that is no Leap message, with file and line
  Read read(TrackedFrame& frame, std::chrono::milliseconds timeout) override;

  bool recorded() const override { return true; }

  /// The newest line about a hand that was left out.
  std::string takeFault() override { return std::exchange(new_drop_, {}); }

  std::uint64_t droppedHands() const { return dropped_hands_; }
  const std::string& lastDrop() const { return last_drop_; }  // one line, empty while there was none

 private:
  void toBegin();
  void openLeapjs();
  void requireBones();
  void requireMicroseconds();
  void startAnew();
  bool readLine(std::string& line);
  bool readMessage(std::string& message, std::string& where);
  std::optional<LeapFrame> nextFrame();
  void rewind();
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  std::unique_ptr<gzFile_s, files::CloseGzip> file_;
  bool loop_ = false;
  std::uint64_t line_ = 0;                 // number of the last line or message
  std::optional<LeapjsRecording> leapjs_;  // none: each line of the file is a message
  std::optional<int> protocol_;            // as the recording states it
  std::optional<LeapFrame> first_;         // read by open(), not returned yet

  LoopStamps stamps_;

  std::uint64_t dropped_hands_ = 0;
  std::string last_drop_, new_drop_;
};

}  // namespace tactile_clay::hand
