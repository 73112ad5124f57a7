#pragma once

#include <ros/ros.h>

#include <memory>

#include "device/array_device.h"
#include "nodes/array_model.h"
#include "nodes/gated_array.h"
#include "nodes/plugin.h"

namespace tactile_clay::nodes {

/// Owns one array, a device plugin named by `~device`, behind the safety gate. The plugin is opened with the
/// texts of `~port`, `~temperature` and `~device_options`, a map or one text "key=value key=value ...".
/// The gate judges the drive that the device will send or, where it takes points, that of the model
/// `~layout`. `~temperature` is that of the air for both. What a device plays that takes drives goes to
/// `array/drive` too, and where its transducers are to `array/geometry`, unless `~publish_drive` is false.
class ArrayDriver {
 public:
  /// @throws std::runtime_error with one line where a parameter is wrong or the device cannot be opened
  ArrayDriver(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  ultrasound::PhaseSolution solve(const std::vector<ultrasound::FocalPoint>& points,
                                  const ultrasound::Drive* before) const;
  ultrasound::FieldSolution solveField(const std::vector<ultrasound::FocalPoint>& targets, double amplitude,
                                       const std::vector<ultrasound::Drive>& before, double effort) const;
  void publishDrive(const device::Sound& sound, const std_msgs::Header& header) const;

  std::string name_;
  ArrayModel model_;
  Plugin<device::ArrayDevice> device_;
  ros::Publisher drive_, geometry_;
  std::unique_ptr<GatedArray> array_;  // goes first, and silences the device
};

}  // namespace tactile_clay::nodes
