#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace tactile_clay::hand {

/// A recording as leapjs-playback saves it: one JSON object {"metadata": {...}, "frames": [...]}, or the same
/// compressed with LZ-string in base64 (.json.lz). Frames are messages of Leap's protocol; packed (format 2),
/// the first one holds the names of the values that the others give in that order. An array of messages alone
/// is taken as well. Holds the text, and reads a frame of it at a time.
class LeapjsRecording {
 public:
  /// Whether the text that begins like this is one, and not a message a line.
  static bool isOne(const std::string& begin);

  /// @param max_bytes of the text once it is unpacked
  /// @throws std::runtime_error with a few words where it is none
  LeapjsRecording(std::string text, std::size_t max_bytes);

  std::size_t frames() const { return frames_.size(); }

  /// One message, as the service would have sent it.
  /// @throws std::runtime_error where it is none
  std::string frame(std::size_t index) const;

 private:
  using Extent = std::pair<std::size_t, std::size_t>;  // begin and length in the text

  std::string at(Extent extent) const { return text_.substr(extent.first, extent.second); }

  std::string text_, names_;  // names of packed values as JSON, empty where frames are not packed
  std::vector<Extent> frames_;
};

}  // namespace tactile_clay::hand
