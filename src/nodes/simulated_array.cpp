#include "nodes/simulated_array.h"

#include <tactile_clay/ArrayDrive.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <stdexcept>

#include "nodes/array_markers.h"
#include "nodes/cloud.h"
#include "nodes/conversions.h"
#include "nodes/params.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

constexpr double height_without_focus = 0.15;  // m, of the slice

}  // namespace

SimulatedArray::SimulatedArray(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : model_(private_nh),
      slice_height_(paramIn(private_nh, "slice_height", 0.0, 0.0, 1.0)),
      slice_size_(paramIn(private_nh, "slice_size", 0.16, 0.01, 1.0)),
      slice_step_(paramIn(private_nh, "slice_step", 0.004, 0.0005, 0.1)),
      skin_field_(param(private_nh, "skin_field", true)),
      slice_field_(param(private_nh, "slice_field", true)),
      nh_(nh) {
  const unsigned queue = param(private_nh, "lockstep", false) ? 0 : 1;
  drive_publisher_ = nh.advertise<ArrayDrive>(topic::array_drive, queue);
  measured_ = nh.advertise<FocalPointArray>(topic::array_measured, queue);
  field_ = nh.advertise<sensor_msgs::PointCloud2>(topic::array_field, queue);
  geometry_ = nh.advertise<visualization_msgs::MarkerArray>(topic::array_geometry, 1, true);
  geometry_.publish(arrayMarkers(model_.layout));

  GatedArray::Output output;
  output.head_spl = [this](const device::Emission& emission) { return solve(emission); };
  output.emit = [this](const device::Emission& emission, const std_msgs::Header& header) {
    emit(emission, header);
  };
  output.silence = [this](const std_msgs::Header& header) { silence(header); };
  output.fault = [] { return std::string(); };
  array_ = std::make_unique<GatedArray>(nh, private_nh, "simulated", false, std::move(output));
}

std::optional<double> SimulatedArray::solve(const device::Emission& emission) {
  try {
    drive_ = model_.solve(emission);
    return ultrasound::headSpl(model_.layout, model_.acoustics, drive_, model_.head_point);
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // the gate names what is wrong
  }
}

void SimulatedArray::emit(const device::Emission& emission, const std_msgs::Header& header) {
  publishDrive(header);
  publishMeasured(emission, header);
  publishField(emission, header);
}

void SimulatedArray::silence(const std_msgs::Header& header) {
  // One silent drive for each frame that was refused, and one when the array goes silent by itself.
  drive_.phase.assign(model_.layout.size(), 0.0f);
  drive_.amplitude.assign(model_.layout.size(), 0.0f);
  if (ros::ok()) publishDrive(header);
}

void SimulatedArray::publishDrive(const std_msgs::Header& header) {
  auto message = boost::make_shared<ArrayDrive>();
  message->header = header;
  message->layout = model_.layout.name;
  message->phase = drive_.phase;
  message->amplitude = drive_.amplitude;
  drive_publisher_.publish(message);
}

void SimulatedArray::publishMeasured(const device::Emission& emission, const std_msgs::Header& header) {
  auto message = boost::make_shared<FocalPointArray>();
  message->header = header;
  message->modulation_frequency = static_cast<float>(emission.modulation_frequency);
  message->points = toMessage(emission.points);
  for (std::size_t i = 0; i < emission.points.size(); ++i)
    message->points[i].pressure = static_cast<float>(std::abs(
        ultrasound::pressureAt(model_.layout, model_.acoustics, drive_, emission.points[i].position)));
  measured_.publish(message);
}

std::vector<Eigen::Vector3f> SimulatedArray::slice(double height) const {
  std::vector<Eigen::Vector3f> points;
  const int half = static_cast<int>(0.5 * slice_size_ / slice_step_);
  for (int row = -half; row <= half; ++row)
    for (int column = -half; column <= half; ++column)
      points.emplace_back(Eigen::Vector3d(column * slice_step_, row * slice_step_, height).cast<float>());
  return points;
}

std::vector<Eigen::Vector3f> SimulatedArray::facingSkin() {
  if (!skin_subscriber_)
    skin_subscriber_ = nh_.subscribe<sensor_msgs::PointCloud2>(
        topic::hands_skin, 1, [this](const sensor_msgs::PointCloud2::ConstPtr& skin) { skin_ = skin; });
  std::vector<Eigen::Vector3f> points;
  if (!skin_ || pointCount(*skin_) == 0) return points;
  const auto pose = transforms_.lookup(frame::array, skin_->header.frame_id, ros::Time(0));
  if (!pose) return points;
  const PressureSkin skin = pressureSkin(*skin_);
  const Eigen::Isometry3f to_array = pose->cast<float>();
  for (std::size_t i = 0; i < skin.position.size(); ++i) {
    const Eigen::Vector3f position = to_array * skin.position[i];
    if (position.dot(to_array.linear() * skin.normal[i]) < 0.0f) points.push_back(position);
  }
  return points;
}

void SimulatedArray::publishField(const device::Emission& emission, const std_msgs::Header& header) {
  if (field_.getNumSubscribers() == 0) {
    skin_subscriber_.shutdown();
    skin_.reset();
    return;
  }
  std::vector<Eigen::Vector3f> points;
  if (skin_field_) points = facingSkin();
  if (slice_field_) {
    double height = slice_height_;
    if (height == 0.0) {
      const auto strongest =
          std::max_element(emission.points.begin(), emission.points.end(),
                           [](const auto& a, const auto& b) { return a.intensity < b.intensity; });
      height = strongest == emission.points.end() ? height_without_focus : strongest->position.z();
    }
    const auto plane = slice(height);
    points.insert(points.end(), plane.begin(), plane.end());
  }
  const auto pressures = ultrasound::pressuresAt(model_.layout, model_.acoustics, drive_, points);
  CloudWriter cloud(header, "x y z pressure", points.size());
  for (std::size_t i = 0; i < points.size(); ++i) cloud.vector(points[i]) << std::abs(pressures[i]);
  field_.publish(cloud.finish());
}

}  // namespace tactile_clay::nodes
