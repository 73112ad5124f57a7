#include "nodes/sample_clock.h"

#include <ros/console.h>

#include <algorithm>
#include <stdexcept>

#include "nodes/stamps.h"

namespace tactile_clay::nodes {
namespace {

const ros::WallDuration clock_patience(10.0);  // s, for a first time on /clock
const ros::WallDuration standing_clock(5.0);   // s, until the first warning, and until the next one

}  // namespace

void waitForClock(const std::function<bool()>& stopped) {
  const ros::SteadyTime start = ros::SteadyTime::now();
  while (!stopped() && ros::Time::isSimTime() && ros::Time::now().isZero()) {
    if (ros::SteadyTime::now() - start > clock_patience)
      throw std::runtime_error(
          "use_sim_time is true on this master, and no time came on /clock within 10 s: start the "
          "clock, or `rosparam delete /use_sim_time`");
    ros::WallDuration(0.05).sleep();
  }
}

std::chrono::nanoseconds SampleClock::ofLive(const hand::TrackedFrame& frame) {
  using std::chrono::steady_clock;
  const steady_clock::time_point now = steady_clock::now();
  const bool told = frame.received != steady_clock::time_point();
  const auto sampled = device_(frame.stamp, (told ? frame.received : now).time_since_epoch());
  restarts_ = device_.restarts();
  const auto ros_now = toCore(ros::Time::now());
  // Simulated time may stand still or run at any speed. The stamp is then the time of arrival.
  const auto stamp = ros::Time::isSimTime() ? ros_now : ros_now - (now.time_since_epoch() - sampled);
  return std::max(stamp, last_ + std::chrono::microseconds(1));
}

std::chrono::nanoseconds SampleClock::ofRecording(const hand::TrackedFrame& frame) {
  const auto stamp = recording_(frame.stamp);
  if (recording_.repaired() > repaired_) {
    repaired_ = recording_.repaired();
    ROS_WARN_THROTTLE(5.0, "hand_tracking: stamp %.6f s is not after the one before: replaced by %.6f s",
                      1e-9 * static_cast<double>(frame.stamp.count()),
                      1e-9 * static_cast<double>(stamp.count()));
  }
  return stamp;
}

std::chrono::nanoseconds SampleClock::ofPlayed(std::chrono::nanoseconds late) const {
  // As for a live tracker: a simulated clock may stand still or run at any speed.
  const auto now = toCore(ros::Time::now());
  return std::max(ros::Time::isSimTime() ? now : now - late, last_ + std::chrono::microseconds(1));
}

std::chrono::nanoseconds SampleClock::next() const {
  return std::max(toCore(ros::Time::now()), last_ + std::chrono::microseconds(1));
}

// The throttle of the console goes by ROS time, and would stand still as well.
void SampleClock::tellStanding() {
  const ros::Time now = ros::Time::now();
  const ros::SteadyTime real = ros::SteadyTime::now();
  if (!ros::Time::isSimTime() || now != clock_time_) {
    clock_time_ = now;
    clock_moved_ = real;
  } else if (real - clock_moved_ > standing_clock) {
    clock_moved_ = real;
    ROS_WARN(
        "hand_tracking: use_sim_time is true, but /clock does not advance: all samples get the same time");
  }
}

}  // namespace tactile_clay::nodes
