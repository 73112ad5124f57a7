#pragma once

#include <ros/time.h>

#include <atomic>
#include <chrono>
#include <functional>

#include "hand/device_clock.h"
#include "hand/tracked_hand.h"
#include "nodes/recording_time.h"

namespace tactile_clay::nodes {

/// With use_sim_time all times come from /clock, and would stand still without one; a player of hands may
/// bring it later. Waits for a first time.
/// @param stopped whether the wait is to end
/// @throws std::runtime_error with one line where none comes
void waitForClock(const std::function<bool()>& stopped);

/// The stamps of samples of hands. They increase.
class SampleClock {
 public:
  /// ROS time at which the device of a live tracker took a sample (device_clock.h).
  std::chrono::nanoseconds ofLive(const hand::TrackedFrame& frame);

  /// Stamp of a recorded sample in the time of its recording; repaired where it does not follow the one
  /// before, which is told.
  std::chrono::nanoseconds ofRecording(const hand::TrackedFrame& frame);

  /// ROS time at which a sample of a recording was due: samples that a busy computer releases late, several
  /// at once, stay as far apart as they were.
  /// @param late how long it has been due
  std::chrono::nanoseconds ofPlayed(std::chrono::nanoseconds late) const;

  /// Now, but later than what was released last.
  std::chrono::nanoseconds next() const;

  /// A sample with this stamp goes on its way.
  void released(std::chrono::nanoseconds stamp) { last_ = stamp; }

  /// Tells it where use_sim_time stands still.
  void tellStanding();

  /// Since the start; of any thread.
  unsigned repaired() const { return repaired_; }
  unsigned restarts() const { return restarts_; }

 private:
  RecordingTime recording_;
  hand::DeviceClock device_;
  std::chrono::nanoseconds last_{0};  // that was released
  ros::Time clock_time_;              // of use_sim_time
  ros::SteadyTime clock_moved_;       // when it was another, or told to stand still
  std::atomic<unsigned> repaired_{0}, restarts_{0};
};

}  // namespace tactile_clay::nodes
