#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>

#include "nodes/health.h"
#include "nodes/inbox.h"
#include "nodes/live_parameters.h"
#include "ultrasound/focal_points.h"

namespace tactile_clay::nodes {

/// Settings of the renderer.
/// @throws std::runtime_error, std::invalid_argument with one line where one is wrong
ultrasound::FocalPointConfig focalPointConfig(Settings& settings);

/// Of them, those of a person (`staircase` writes them).
/// @throws as above
void readPerson(Settings& settings, ultrasound::FocalPointConfig& config);

/// Hz, at which points are modulated; 0: that of the modulation.
/// @throws as above
double modulationFrequency(Settings& settings);

/// s/m, by which slip becomes vibration (ultrasound::slipShare); 0: none.
/// @throws as above
double slipGain(Settings& settings);

/// Renders `hands/pressure` as focal points (Eq. 8, 9): one `array/focal_points` for each, with no points
/// where nothing is touched, and one `array/rendering` that tells how well they stand for it. `~modulation`
/// is am, lateral, stm, field, circle or field_circle; the points of a field are samples of skin, pressed and
/// bare, and it is the array that reports on them. Settings may change while it runs (LiveParameters), but
/// not from points to a field or back, for which the nodes before and behind are set at their start.
class FocalPointRenderer {
 public:
  /// @throws std::runtime_error, std::invalid_argument with one line where a parameter is wrong
  FocalPointRenderer(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  LiveParameters::Apply read(Settings& settings);
  void receive(const sensor_msgs::PointCloud2::ConstPtr& pressure);
  double frequency(const std::vector<ultrasound::FocalPoint>& points) const;
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ultrasound::FocalPointRenderer renderer_;
  float modulation_frequency_ = 0.0f;  // Hz; 0: that of the modulation
  double slip_gain_ = 0.0;             // s/m
  unsigned frames_ = 0, bad_frames_ = 0;
  std::size_t points_ = 0, compressed_ = 0, saturated_ = 0, merged_ = 0, raised_ = 0, ignored_ = 0;
  double error_ = 0.0, weighted_error_ = 0.0;

  LiveParameters live_;
  Inbox inbox_;
  ros::Subscriber subscriber_;
  ros::Publisher publisher_, report_publisher_;
  Health health_;
};

}  // namespace tactile_clay::nodes
