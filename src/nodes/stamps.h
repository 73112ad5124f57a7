#pragma once

#include <ros/time.h>

#include <chrono>
#include <string>

namespace tactile_clay::nodes {

/// A stamp in a message may be any two numbers of 32 bits. ROS's own arithmetic throws, or wraps around, if a
/// result does not fit into its 32 bits. Therefore all computations with stamps of messages use these
/// functions, which never throw.

/// The end of the stamps for computations, in the year 2038: differences of ROS times have 31 bits.
constexpr std::chrono::seconds stamp_end{1LL << 31};

/// Empty, or what is wrong with a stamp of a message, and what was expected.
std::string faultOf(const ros::Time& stamp);

/// A time beyond the end of stamps, or before 0, becomes the nearest valid time.
std::chrono::nanoseconds toCore(const ros::Time& stamp);
ros::Time toRos(std::chrono::nanoseconds stamp);

/// s from one stamp to another, negative if `to` is earlier.
double secondsBetween(const ros::Time& from, const ros::Time& to);

/// Whether a stamp is more than a second later than `now`, which never happens on one host or on two whose
/// clocks agree. False if simulated time has not begun.
bool isOfTheFuture(const ros::Time& stamp, const ros::Time& now);

}  // namespace tactile_clay::nodes
