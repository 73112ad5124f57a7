#pragma once

#include <ros/time.h>

#include <chrono>
#include <string>

namespace tactile_clay::nodes {

/// A stamp in a message may be any two numbers of 32 bits. ROS's own arithmetic throws, or wraps around,
/// where a result does not fit into its 32 bits. All that is reckoned with stamps of messages passes here,
/// and nothing here throws.

/// The end of stamps that can be reckoned with: differences of ROS times have 31 bits. The year 2038.
constexpr std::chrono::seconds stamp_end{1LL << 31};

/// Empty, or what is wrong with a stamp of a message, and what was expected.
std::string faultOf(const ros::Time& stamp);

/// What is beyond the end of stamps, or before 0, becomes the nearest that is not.
std::chrono::nanoseconds toCore(const ros::Time& stamp);
ros::Time toRos(std::chrono::nanoseconds stamp);

/// s from one stamp to another, negative where it is the earlier one.
double secondsBetween(const ros::Time& from, const ros::Time& to);

/// Whether a stamp is more than a second later than `now`, as none is on one host or on two whose clocks
/// agree. Where simulated time has not begun, nothing is.
bool isOfTheFuture(const ros::Time& stamp, const ros::Time& now);

}  // namespace tactile_clay::nodes
