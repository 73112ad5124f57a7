#include "nodes/simulated_array.h"

#include <tactile_clay/AcousticReport.h>
#include <tactile_clay/ArrayDrive.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <stdexcept>

#include "nodes/array_markers.h"
#include "nodes/cloud.h"
#include "nodes/conversions.h"
#include "nodes/params.h"
#include "nodes/topics.h"
#include "ultrasound/modulation.h"
#include "ultrasound/side_lobes.h"

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
  report_ = nh.advertise<AcousticReport>(topic::acoustics, queue);
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

ultrasound::PhaseSolution SimulatedArray::solution(const device::Emission& emission) const {
  const bool limited = model_.options.max_phase_change > 0.0 && !solution_.drive.phase.empty();
  return ultrasound::solvePhases(model_.layout, model_.acoustics, emission.points, model_.options,
                                 limited ? &solution_.drive : nullptr);
}

std::optional<double> SimulatedArray::solve(const device::Emission& emission) {
  try {
    return ultrasound::headSpl(model_.layout, model_.acoustics, solution(emission).drive, model_.head_point);
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // the gate names what is wrong
  }
}

void SimulatedArray::emit(const device::Emission& emission, const std_msgs::Header& header) {
  solution_ = solution(emission);
  publishDrive(header);
  publishMeasured(emission, header);
  publishReport(emission, header);
  publishField(emission, header);
}

void SimulatedArray::silence(const std_msgs::Header& header) {
  // One silent drive for each frame that was refused, and one when the array goes silent by itself.
  solution_.drive.phase.assign(model_.layout.size(), 0.0f);
  solution_.drive.amplitude.assign(model_.layout.size(), 0.0f);
  if (ros::ok()) publishDrive(header);
}

void SimulatedArray::publishDrive(const std_msgs::Header& header) {
  auto message = boost::make_shared<ArrayDrive>();
  message->header = header;
  message->layout = model_.layout.name;
  message->phase = solution_.drive.phase;
  message->amplitude = solution_.drive.amplitude;
  drive_publisher_.publish(message);
}

void SimulatedArray::publishReport(const device::Emission& emission, const std_msgs::Header& header) {
  if (report_.getNumSubscribers() == 0) return;
  auto message = boost::make_shared<AcousticReport>();
  message->header = header;
  std::vector<double> achieved;
  for (const ultrasound::FocalPoint& point : emission.points) {
    achieved.push_back(
        std::abs(ultrasound::pressureAt(model_.layout, model_.acoustics, solution_.drive, point.position)));
    message->id.push_back(point.id);
  }
  message->commanded.assign(solution_.target.begin(), solution_.target.end());
  message->achieved.assign(achieved.begin(), achieved.end());
  message->error = static_cast<float>(ultrasound::relativeError(achieved, solution_.target));
  const auto points = slice(emission);
  const auto lobe = ultrasound::strongestSideLobe(
      points, ultrasound::pressuresAt(model_.layout, model_.acoustics, solution_.drive, points),
      emission.points, achieved, 2.0 * model_.acoustics.wavelength());
  message->side_lobe = static_cast<float>(lobe.share);
  message->side_lobe_position.x = lobe.position.x();
  message->side_lobe_position.y = lobe.position.y();
  message->side_lobe_position.z = lobe.position.z();
  message->head_spl = static_cast<float>(
      ultrasound::headSpl(model_.layout, model_.acoustics, solution_.drive, model_.head_point));
  report_.publish(message);
}

void SimulatedArray::publishMeasured(const device::Emission& emission, const std_msgs::Header& header) {
  auto message = boost::make_shared<FocalPointArray>();
  message->header = header;
  message->modulation_frequency = static_cast<float>(emission.modulation_frequency);
  message->points = toMessage(emission.points);
  for (std::size_t i = 0; i < emission.points.size(); ++i)
    message->points[i].pressure = static_cast<float>(std::abs(ultrasound::pressureAt(
        model_.layout, model_.acoustics, solution_.drive, emission.points[i].position)));
  measured_.publish(message);
}

std::vector<Eigen::Vector3f> SimulatedArray::slice(const device::Emission& emission) const {
  double height = slice_height_;
  if (height == 0.0) {
    const auto strongest =
        std::max_element(emission.points.begin(), emission.points.end(),
                         [](const auto& a, const auto& b) { return a.intensity < b.intensity; });
    height = strongest == emission.points.end() ? height_without_focus : strongest->position.z();
  }
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
    const auto plane = slice(emission);
    points.insert(points.end(), plane.begin(), plane.end());
  }
  const auto pressures = ultrasound::pressuresAt(model_.layout, model_.acoustics, solution_.drive, points);
  // The gate passes amplitude modulation only: one drive, swelling and fading.
  const auto instants = ultrasound::period(emission.points, ultrasound::Modulation::amplitude);
  double power = 0.0;  // mean of the squared envelope
  for (const auto& instant : instants)
    power += instant.amplitude * instant.amplitude / static_cast<double>(instants.size());
  CloudWriter cloud(header, "x y z pressure tactile", points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float amplitude = std::abs(pressures[i]);
    cloud.vector(points[i]) << amplitude
                            << static_cast<float>(power *
                                                  ultrasound::radiationPressure(model_.acoustics, amplitude));
  }
  field_.publish(cloud.finish());
}

}  // namespace tactile_clay::nodes
