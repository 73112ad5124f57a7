#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <tactile_clay/ArrayState.h>
#include <tactile_clay/ClayStatus.h>
#include <tactile_clay/RenderingReport.h>
#include <tactile_clay/RigNumbers.h>

#include <vector>

#include "nodes/inbox.h"

namespace tactile_clay::nodes {

/// The parts of a RigNumbers that a message tells, in the units of their names.
void takeNumbers(const ClayStatus& status, RigNumbers& numbers);
void takeNumbers(const sensor_msgs::PointCloud2& pressure, RigNumbers& numbers);
void takeNumbers(const RenderingReport& report, RigNumbers& numbers);
void takeNumbers(const ArrayState& state, RigNumbers& numbers);

/// All of them NaN.
RigNumbers unknownNumbers();

/// What is worth a plot, for rqt_plot and PlotJuggler: `clay/status`, `hands/pressure`, `array/rendering` and
/// `array/state` in, `rig/numbers` out, one message for each state of the array. While nobody subscribes to
/// it, it does not subscribe either.
class RigNumbersNode {
 public:
  RigNumbersNode(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  void look();
  template <typename Message>
  void follow(const char* topic);

  ros::NodeHandle nh_;
  RigNumbers numbers_;
  Inbox inbox_;
  std::vector<ros::Subscriber> subscribers_;  // only while somebody looks
  ros::Publisher publisher_;
  ros::WallTimer timer_;
};

}  // namespace tactile_clay::nodes
