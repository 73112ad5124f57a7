#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>

#include "nodes/health.h"
#include "nodes/inbox.h"
#include "nodes/live_parameters.h"
#include "ultrasound/focal_points.h"

namespace tactile_clay::nodes {

/// Reads the settings of the renderer.
/// @throws std::runtime_error, std::invalid_argument with one line if one is wrong
ultrasound::FocalPointConfig focalPointConfig(Settings& settings);

/// Reads those settings that belong to a person (`staircase` writes them).
/// @throws as above
void readPerson(Settings& settings, ultrasound::FocalPointConfig& config);

/// Reads the frequency at which points are modulated, Hz; 0: the default of the modulation.
/// @throws as above
double modulationFrequency(Settings& settings);

/// Reads the share of the pressure that vibrates per m/s of slip, s/m (ultrasound::slipShare); 0: none.
/// @throws as above
double slipGain(Settings& settings);

/// Renders `hands/pressure` as focal points (Eq. 8, 9). For each message it publishes one
/// `array/focal_points`, without points if nothing is touched, and one `array/rendering`, which reports how
/// well the points reproduce the pressure. `~modulation` is am, lateral, stm, field, circle or field_circle.
/// The points of a field are skin samples, pressed and bare; for a field the array publishes the report.
/// Settings may change while the node runs (LiveParameters). A change from points to a field or back is
/// refused, because the nodes before and behind this one are set for it at their start.
class FocalPointRenderer {
 public:
  /// @throws std::runtime_error, std::invalid_argument with one line if a parameter is wrong
  FocalPointRenderer(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  LiveParameters::Apply read(Settings& settings);
  void receive(const sensor_msgs::PointCloud2::ConstPtr& pressure);
  double frequency(const std::vector<ultrasound::FocalPoint>& points) const;
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ultrasound::FocalPointRenderer renderer_;
  float modulation_frequency_ = 0.0f;  // Hz; 0: the default of the modulation
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
