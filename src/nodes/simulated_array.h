#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>

#include <memory>
#include <vector>

#include "nodes/array_model.h"
#include "nodes/gated_array.h"
#include "nodes/transforms.h"

namespace tactile_clay::nodes {

/// Stands in for a real array: same input, gate and state. Solves the phases of the arrays `~layout` and
/// publishes them (`array/drive`), with the pressure of their true field at each focal point
/// (`array/measured`). While somebody subscribes: how that compares with what was commanded, side lobes and
/// the level at the head
/// (`array/acoustics`); on the skin and on a slice the acoustic amplitude and the tactile pressure, the
/// radiation pressure averaged over a period of the modulation (`array/field`).
class SimulatedArray {
 public:
  /// \throws std::runtime_error, std::invalid_argument with one line where a parameter is wrong
  SimulatedArray(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  std::optional<double> solve(const device::Emission& emission);
  void emit(const device::Emission& emission, const std_msgs::Header& header);
  void silence(const std_msgs::Header& header);
  ultrasound::PhaseSolution solution(const device::Emission& emission) const;
  void publishDrive(const std_msgs::Header& header);
  void publishReport(const device::Emission& emission, const std_msgs::Header& header);
  void publishMeasured(const device::Emission& emission, const std_msgs::Header& header);
  void publishField(const device::Emission& emission, const std_msgs::Header& header);
  std::vector<Eigen::Vector3f> slice(const device::Emission& emission) const;
  std::vector<Eigen::Vector3f> facingSkin();

  ArrayModel model_;
  ultrasound::PhaseSolution solution_;  // of the emission in force

  double slice_height_;  // m above the array; 0: of the strongest focal point
  double slice_size_, slice_step_;
  bool skin_field_, slice_field_;
  Transforms transforms_;
  sensor_msgs::PointCloud2::ConstPtr skin_;

  ros::NodeHandle nh_;
  ros::Subscriber skin_subscriber_;
  ros::Publisher drive_publisher_, measured_, report_, field_, geometry_;
  std::unique_ptr<GatedArray> array_;  // goes first, and silences the rest
};

}  // namespace tactile_clay::nodes
