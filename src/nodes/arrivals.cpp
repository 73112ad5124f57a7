#include "nodes/arrivals.h"

#include <ros/console.h>

#include "nodes/player.h"
#include "nodes/stamps.h"

namespace tactile_clay::nodes {

void Arrivals::seeHands(const TrackedHands& hands, const std::string& publisher) {
  if (publisher != hands_publisher_) {
    hands_publisher_ = publisher;
    stamps_.restart();
  }
  hands_came_ = ros::SteadyTime::now();
  hands_stamp_ = hands.header.stamp;
  hands_tracked_ = !hands.hands.empty();
}

device::StampCheck::Age Arrivals::ageOf(const ros::Time& stamp) {
  const double behind = secondsBetween(stamp, ros::Time::now());
  const bool before = stamps_.ofRecording();
  const device::StampCheck::Age age = stamps_(behind, isPlayer(hands_publisher_));
  if (stamps_.ofRecording() && !before)
    ROS_WARN_THROTTLE(
        1.0,
        "array '%s': stamps of focal points are %.1f s behind this computer's clock, so they are taken for "
        "those of a recording, and their age is not checked. If they are live, compare the hosts' clocks",
        device_.c_str(), behind);
  return age;
}

device::Occasion Arrivals::occasion(const ros::Time& stamp) {
  device::Occasion occasion;
  const ros::SteadyTime now = ros::SteadyTime::now();
  if (lockstep_) {
    // Repeatable: time is measured by the stamps, and a message without hands counts only if it is not older
    // than the points.
    occasion.since_last = secondsBetween(last_stamp_, stamp);
    occasion.hands_tracked = hands_tracked_ || !hands_came_ || hands_stamp_ < stamp;
  } else {
    occasion.since_last = (now - last_came_).toSec();
    // An array that never got a message of hands belongs to a rig without a tracker.
    occasion.hands_tracked = hands_tracked_ || !hands_came_;
    occasion.hands_age = hands_came_ ? (now - *hands_came_).toSec() : 0.0;
  }
  last_came_ = now;
  last_stamp_ = stamp;
  return occasion;
}

}  // namespace tactile_clay::nodes
