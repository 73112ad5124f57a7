#pragma once

#include <chrono>
#include <string>

#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// What a source is opened with; every value as given at launch, empty where not given.
struct SourceOptions {
  std::string file;   // of a recording
  std::string url;    // of a networked tracker
  std::string topic;  // of a topic source, and of the hands in a bag
  bool loop = false;  // a recording starts again at its end
};

/// Where tracked hands come from. One implementation a tracker or recording format; loaded by pluginlib under
/// this base class. A source neither filters nor places hands: it speaks in its own frame, clock and units of
/// m.
class HandSource {
 public:
  enum class Read {
    frame,    // `frame` was filled
    nothing,  // no frame came within the time-out
    ended     // the source has no more frames, for good
  };

  virtual ~HandSource() = default;

  /// Opens the device or recording.
  /// @throws std::runtime_error with one line: what, where, what was expected
  virtual void open(const SourceOptions& options) = 0;

  /// Next frame. A recording returns its frames one after the other without waiting; pacing them by
  /// `frame.stamp` is the caller's. A live source waits at most `timeout` and returns the newest frame.
  virtual Read read(TrackedFrame& frame, std::chrono::milliseconds timeout) = 0;

  /// True where frames come from a file, each with its own time stamp, and can be replayed at any speed.
  virtual bool recorded() const = 0;

  /// True where the hands were cleaned before, as recorded `hands/tracked` are; asked once it is open.
  virtual bool cleaned() const { return false; }

  /// What went wrong since the last call, the newest in one line: a tracker that cannot be reached, a message
  /// that is none. Empty if nothing did. Called by the thread that reads.
  virtual std::string takeFault() { return {}; }
};

}  // namespace tactile_clay::hand
