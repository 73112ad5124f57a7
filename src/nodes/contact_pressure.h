#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>

#include "nodes/cloud_join.h"
#include "nodes/health.h"
#include "nodes/inbox.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {

/// Turns forces on the skin into pressure (Eq. 7): joins `clay/contacts` with the `hands/skin` of the same
/// stamp, and publishes one `hands/pressure` for each, in frame `array`. Its places, normals and areas are
/// those of the tracked hand, which feels the pressure, also where the skin that the clay meets is that of a
/// virtual hand beside it (`tracked_x` and so on in `hands/skin`). With `~around`, m, the skin that faces the
/// array within so far of a pressed sample comes with it, at pressure 0: fields have to leave it alone.
class ContactPressure {
 public:
  /// @throws std::runtime_error with one line where a parameter is wrong
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
  CloudJoin join_;

  Inbox inbox_;
  ros::Subscriber skin_, contacts_;
  ros::Publisher publisher_;
  double around_;  // m
  Health health_;
};

}  // namespace tactile_clay::nodes
