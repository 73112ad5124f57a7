#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <tactile_clay/ArrayState.h>
#include <tactile_clay/ClayStatus.h>
#include <tactile_clay/RenderingReport.h>
#include <tactile_clay/RigNumbers.h>

#include <optional>
#include <vector>

#include "nodes/inbox.h"
#include "nodes/stage_latency.h"

namespace tactile_clay::nodes {

/// Copies the numbers of a message into a RigNumbers, in the units of their names.
void takeNumbers(const ClayStatus& status, RigNumbers& numbers);
void takeNumbers(const sensor_msgs::PointCloud2& pressure, RigNumbers& numbers);
void takeNumbers(const RenderingReport& report, RigNumbers& numbers);
void takeNumbers(const ArrayState& state, RigNumbers& numbers);

/// A RigNumbers in which all numbers are NaN.
RigNumbers unknownNumbers();

/// Numbers for plots with rqt_plot and PlotJuggler: `clay/status`, `hands/pressure`, `array/rendering` and
/// `array/state` in, `rig/numbers` out, one message per state of the array. Also the latency of each stage
/// (StageLatency) on `rig/latency`, one message per second. The node subscribes only while somebody
/// subscribes to its output.
class RigNumbersNode {
 public:
  RigNumbersNode(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  void look();
  void lookAtLatency();
  template <typename Message>
  void follow(const char* topic);
  template <typename Message>
  void time(std::size_t topic);

  ros::NodeHandle nh_;
  RigNumbers numbers_;
  Inbox inbox_;
  std::vector<ros::Subscriber> subscribers_;  // only while somebody subscribes
  std::optional<StageLatency> latency_;       // only while somebody subscribes
  std::vector<ros::Subscriber> timed_;        // only while somebody subscribes
  ros::Publisher publisher_, latency_publisher_;
  ros::WallTimer timer_, latency_timer_;
};

}  // namespace tactile_clay::nodes
