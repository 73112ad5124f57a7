#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace tactile_clay::hand {

/// A recording as leapjs-playback saves it: one JSON object {"metadata": {...}, "frames": [...]}, or the same
/// compressed with LZ-string in base64 (.json.lz). Frames are messages of Leap's protocol. If they are packed
/// (format 2), the first one lists the names of the values, and the others contain the values in that order.
/// An array of messages alone is accepted as well. Keeps the text, and reads one frame of it at a time.
class LeapjsRecording {
 public:
  /// Whether a text that begins like this is such a recording, not one message per line.
  static bool isOne(const std::string& begin);

  /// @param max_bytes maximum size of the unpacked text
  /// @throws std::runtime_error with a few words if the text is no such recording
  LeapjsRecording(std::string text, std::size_t max_bytes);

  std::size_t frames() const { return frames_.size(); }

  /// One message, as the service would have sent it.
  /// @throws std::runtime_error if the frame is no message
  std::string frame(std::size_t index) const;

 private:
  using Extent = std::pair<std::size_t, std::size_t>;  // begin and length in the text

  std::string at(Extent extent) const { return text_.substr(extent.first, extent.second); }

  std::string text_, names_;  // names_: of packed values, as JSON; empty: frames are not packed
  std::vector<Extent> frames_;
};

}  // namespace tactile_clay::hand
