#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>

#include <string>
#include <vector>

#include "nodes/array_model.h"
#include "nodes/conversions.h"
#include "nodes/inbox.h"
#include "nodes/transforms.h"
#include "ultrasound/modulation.h"

namespace tactile_clay::nodes {

/// What an array plays: a period of its modulation, each part with its drive.
struct Sound {
  struct Part {
    ultrasound::Part what;
    ultrasound::Drive drive;
    std::vector<double> target;  // Pa at each of its points, as the phase solver was asked; empty: not known
  };
  std::vector<ultrasound::FocalPoint> points;  // commanded
  ultrasound::Modulation modulation = ultrasound::Modulation::amplitude;
  double frequency = 0.0;  // Hz
  std::vector<Part> parts;
};

/// Publishes what an array plays, and its true field. `array/drive`: the drive at the time of the stamp, not
/// modulated down. `array/measured`: the pressure at each focal point while it is there, averaged over the
/// period. While somebody subscribes, `array/acoustics`: how that compares with what was commanded, side
/// lobes and the level at the head; `array/field`: on the skin and on a slice the highest acoustic amplitude
/// of the period and the tactile pressure, the radiation pressure averaged over it.
class SoundField {
 public:
  /// Reads `~slice_height`, `~slice_size`, `~slice_step`, `~skin_field`, `~slice_field`, `~lockstep`.
  /// \throws std::runtime_error with one line where a parameter is wrong
  SoundField(ros::NodeHandle nh, ros::NodeHandle private_nh, const ArrayModel& model);

  void publish(const Sound& sound, const std_msgs::Header& header);

  /// The two parts of it: the drive, at once, and what has to be computed.
  void publishDrive(const Sound& sound, const std_msgs::Header& header);
  void publishFields(const Sound& sound, const std_msgs::Header& header);
  void publishSilence(const std_msgs::Header& header);

 private:
  void publishDrive(const ultrasound::Drive& drive, const std_msgs::Header& header);
  void publishMeasured(const Sound& sound, const std_msgs::Header& header);
  void publishReport(const Sound& sound, const std_msgs::Header& header);
  void publishField(const Sound& sound, const std_msgs::Header& header);
  std::vector<Eigen::Vector3f> slice(const Sound& sound) const;
  std::vector<Eigen::Vector3f> facingSkin();

  const ArrayModel& model_;
  double slice_height_;  // m above the array; 0: of the strongest focal point
  double slice_size_, slice_step_;
  bool skin_field_, slice_field_;
  Transforms transforms_;
  Inbox inbox_;
  PressureSkin skin_;  // the newest
  std::string skin_frame_;

  ros::NodeHandle nh_;
  ros::Subscriber skin_subscriber_;
  ros::Publisher drive_, measured_, report_, field_, geometry_;
};

}  // namespace tactile_clay::nodes
