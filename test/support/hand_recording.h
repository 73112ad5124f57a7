#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hand/leap_recording.h"
#include "support/shared_data.h"

namespace tactile_clay::hand {

/// Options of a source that reads a file.
inline SourceOptions fileOptions(const std::string& file, bool loop = false) {
  SourceOptions options;
  options.file = file;
  options.loop = loop;
  return options;
}

/// All frames of a recording of hands; none: the recording is not here.
inline std::optional<std::vector<TrackedFrame>> recordedFrames(const std::string& name) {
  const SourceOptions options = fileOptions(handRecording(name).string());
  if (!std::filesystem::exists(options.file)) return std::nullopt;
  LeapRecording recording;
  recording.open(options);
  std::vector<TrackedFrame> frames;
  TrackedFrame frame;
  while (recording.read(frame, std::chrono::milliseconds(0)) == HandSource::Read::frame)
    frames.push_back(frame);
  return frames;
}

}  // namespace tactile_clay::hand
