#pragma once

#include <ros/time.h>

#include <atomic>
#include <chrono>
#include <functional>

#include "hand/device_clock.h"
#include "hand/tracked_hand.h"
#include "nodes/recording_time.h"

namespace tactile_clay::nodes {

/// Waits for a first time on /clock. With use_sim_time all times come from there, and stand still without it;
/// a program that plays hands may publish it later than this node starts.
/// @param stopped returns whether the wait has to end
/// @throws std::runtime_error with one line if no time comes
void waitForClock(const std::function<bool()>& stopped);

/// Makes the stamps of tracker samples. They increase.
class SampleClock {
 public:
  /// ROS time at which the device of a live tracker took a sample (device_clock.h).
  std::chrono::nanoseconds ofLive(const hand::TrackedFrame& frame);

  /// Stamp of a recorded sample in the time of its recording. If it does not follow the one before, it is
  /// repaired, and this is logged.
  std::chrono::nanoseconds ofRecording(const hand::TrackedFrame& frame);

  /// ROS time at which a sample of a recording was due. Samples that a busy computer releases late, and
  /// several at once, keep their distances in time.
  /// @param late how long the sample has been due
  std::chrono::nanoseconds ofPlayed(std::chrono::nanoseconds late) const;

  /// The time now, but later than the stamp that was released last.
  std::chrono::nanoseconds next() const;

  /// To be called when a sample with this stamp is released.
  void released(std::chrono::nanoseconds stamp) { last_ = stamp; }

  /// Logs a warning if the time of use_sim_time stands still.
  void tellStanding();

  /// Counts since the start; may be called from any thread.
  unsigned repaired() const { return repaired_; }
  unsigned restarts() const { return restarts_; }

 private:
  RecordingTime recording_;
  hand::DeviceClock device_;
  std::chrono::nanoseconds last_{0};  // stamp that was released last
  ros::Time clock_time_;              // newest time of use_sim_time
  ros::SteadyTime clock_moved_;       // when `clock_time_` changed, or a warning was logged
  std::atomic<unsigned> repaired_{0}, restarts_{0};
};

}  // namespace tactile_clay::nodes
