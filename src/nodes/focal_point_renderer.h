#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>

#include "nodes/health.h"
#include "ultrasound/focal_points.h"

namespace tactile_clay::nodes {

/// Renders `hands/pressure` as focal points (Eq. 8, 9): one `array/focal_points` for each, with no points
/// where nothing is touched. Amplitude-modulated.
class FocalPointRenderer {
 public:
  /// \throws std::runtime_error, std::invalid_argument with one line where a parameter is wrong
  FocalPointRenderer(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  void receive(const sensor_msgs::PointCloud2::ConstPtr& pressure);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ultrasound::FocalPointRenderer renderer_;
  float modulation_frequency_;  // Hz
  unsigned frames_ = 0, bad_frames_ = 0;
  std::size_t points_ = 0, clipped_ = 0, ignored_ = 0;

  ros::Subscriber subscriber_;
  ros::Publisher publisher_;
  Health health_;
};

}  // namespace tactile_clay::nodes
