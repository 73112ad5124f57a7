#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>

#include <string>
#include <vector>

#include "device/array_device.h"
#include "nodes/array_model.h"
#include "nodes/conversions.h"
#include "nodes/inbox.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {

/// Publishes what an array plays, and its true field:
/// - `array/drive`: the drive at the time of the stamp, without the envelope of the modulation; for a field
///   all its patterns, one message per pattern.
/// - `array/measured`: the pressure at each focal point while the point is there, averaged over the period.
/// - `array/acoustics`, while somebody subscribes: how these pressures compare with the commanded ones, side
///   lobes, and the level at the head.
/// - `array/field`, while somebody subscribes: on the tracked skin and on a slice the highest acoustic
///   amplitude of the period, and the tactile pressure, which is the radiation pressure averaged over the
///   period.
class SoundField {
 public:
  /// Reads `~slice_height`, `~slice_size`, `~slice_step`, `~skin_field`, `~slice_field`, `~lockstep`.
  /// @throws std::runtime_error with one line if a parameter is wrong
  SoundField(ros::NodeHandle nh, ros::NodeHandle private_nh, ArrayModel model);

  void publish(const device::Sound& sound, const std_msgs::Header& header);

  /// The two parts of `publish`: the drive, which is there at once, and the fields, which have to be
  /// computed.
  void publishDrive(const device::Sound& sound, const std_msgs::Header& header);
  void publishFields(const device::Sound& sound, const std_msgs::Header& header);
  void publishSilence(const std_msgs::Header& header);

 private:
  void publishMeasured(const device::Sound& sound, const std_msgs::Header& header);
  void publishReport(const device::Sound& sound, const std_msgs::Header& header);
  void publishField(const device::Sound& sound, const std_msgs::Header& header);
  std::vector<double> amplitudesAtPoints(const device::Sound::Part& part) const;
  std::vector<Eigen::Vector3f> slice(const device::Sound& sound) const;
  std::vector<Eigen::Vector3f> facingSkin();

  ArrayModel model_;
  double slice_height_;  // m above the array; 0: of the strongest focal point
  double slice_size_, slice_step_;
  bool skin_field_, slice_field_;
  Transforms transforms_;
  Inbox inbox_;
  Skin skin_;  // the newest skin
  std::string skin_frame_;

  ros::NodeHandle nh_;
  ros::Subscriber skin_subscriber_;
  ros::Publisher drive_, measured_, report_, field_, geometry_;
};

}  // namespace tactile_clay::nodes
