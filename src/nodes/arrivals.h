#pragma once

#include <ros/time.h>
#include <tactile_clay/TrackedHands.h>

#include <optional>
#include <string>

#include "device/safety_gate.h"
#include "device/stamp_check.h"

namespace tactile_clay::nodes {

/// When focal points and hands came to an array: how old they are, for the safety gate. Belongs to one
/// thread.
class Arrivals {
 public:
  /// @param device name of the array, for people
  /// @param lockstep the clock is that of the stamps
  /// @param stamps whether those of focal points tell their age
  Arrivals(const std::string& device, bool lockstep, const device::StampCheck& stamps)
      : device_(device), lockstep_(lockstep), stamps_(stamps) {}

  void seeHands(const TrackedHands& hands);
  /// @param node that publishes the hands
  void seePublisher(const std::string& node);

  /// Age of focal points with this stamp, to be asked once of each frame. Tells it when stamps are found to
  /// be of a recording.
  device::StampCheck::Age ageOf(const ros::Time& stamp);

  /// What is known of the times as a frame with this stamp comes, but for its age; to be asked once of each.
  device::Occasion occasion(const ros::Time& stamp);

  /// Whether the stamps are taken for those of a recording.
  bool ofRecording() const { return stamps_.ofRecording(); }
  /// Whether a tracker has told of its hands, and last that there are none.
  bool handsAreGone() const { return hands_came_ && !hands_tracked_; }

 private:
  std::string device_;
  bool lockstep_;
  device::StampCheck stamps_;
  std::string hands_publisher_;
  ros::SteadyTime last_came_;  // a frame
  ros::Time last_stamp_;       // of it
  std::optional<ros::SteadyTime> hands_came_;
  ros::Time hands_stamp_;
  bool hands_tracked_ = false;
};

}  // namespace tactile_clay::nodes
