#pragma once

#include <ros/time.h>
#include <tactile_clay/TrackedHands.h>

#include <optional>
#include <string>

#include "device/safety_gate.h"
#include "device/stamp_check.h"

namespace tactile_clay::nodes {

/// Records when focal points and hands came to an array, so that the safety gate gets their age. For use in
/// one thread.
class Arrivals {
 public:
  /// @param device name of the array, for log lines
  /// @param lockstep whether time is measured by the stamps
  /// @param stamps check that finds the age of focal points from their stamps
  Arrivals(const std::string& device, bool lockstep, const device::StampCheck& stamps)
      : device_(device), lockstep_(lockstep), stamps_(stamps) {}

  /// @param publisher name of the node that publishes the hands
  void seeHands(const TrackedHands& hands, const std::string& publisher);

  /// Age of focal points with this stamp. To be called once per frame. Logs a warning when the stamps are
  /// found to be those of a recording.
  device::StampCheck::Age ageOf(const ros::Time& stamp);

  /// Times at the arrival of a frame with this stamp, without the age of the frame. To be called once per
  /// frame.
  device::Occasion occasion(const ros::Time& stamp);

  /// Whether the stamps are treated as those of a recording.
  bool ofRecording() const { return stamps_.ofRecording(); }
  /// Whether hands were published, and the newest message has no hand.
  bool handsAreGone() const { return hands_came_ && !hands_tracked_; }

 private:
  std::string device_;
  bool lockstep_;
  device::StampCheck stamps_;
  std::string hands_publisher_;
  ros::SteadyTime last_came_;  // when the last frame came
  ros::Time last_stamp_;       // stamp of the last frame
  std::optional<ros::SteadyTime> hands_came_;
  ros::Time hands_stamp_;
  bool hands_tracked_ = false;
};

}  // namespace tactile_clay::nodes
