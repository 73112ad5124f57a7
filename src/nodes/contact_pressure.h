#pragma once

#include <message_filters/subscriber.h>
#include <message_filters/time_synchronizer.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>

#include "nodes/health.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {

/// Turns forces on the skin into pressure (Eq. 7): joins `clay/contacts` with the `hands/skin` of the same
/// stamp, and publishes one `hands/pressure` for each, in frame `array`.
class ContactPressure {
 public:
  /// \throws std::runtime_error with one line where a parameter is wrong
  ContactPressure(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  using Cloud = sensor_msgs::PointCloud2;

  void receive(const Cloud::ConstPtr& skin, const Cloud::ConstPtr& contacts);
  sensor_msgs::PointCloud2Ptr pressure(const Cloud& skin, const Cloud& contacts);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  Transforms transforms_;
  unsigned frames_ = 0, bad_frames_ = 0;
  std::size_t samples_ = 0, dropped_ = 0;
  float highest_ = 0.0f;  // Pa
  ros::TransportHints hints_;

  message_filters::Subscriber<Cloud> skin_, contacts_;
  message_filters::TimeSynchronizer<Cloud, Cloud> join_;
  ros::Publisher publisher_;
  Health health_;
};

}  // namespace tactile_clay::nodes
