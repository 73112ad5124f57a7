#include "nodes/sound_field.h"

#include <tactile_clay/AcousticReport.h>
#include <tactile_clay/FocalPointArray.h>
#include <tf2_eigen/tf2_eigen.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "nodes/array_markers.h"
#include "nodes/cloud.h"
#include "nodes/conversions.h"
#include "nodes/drive_messages.h"
#include "nodes/params.h"
#include "nodes/topics.h"
#include "ultrasound/side_lobes.h"

namespace tactile_clay::nodes {
namespace {

using device::Sound;

constexpr unsigned drive_queue = 128;          // two frames of eight patterns at eight places
constexpr double height_without_focus = 0.15;  // m, of the slice

/// Mean values per focal point, over the time in which the point is there. The index is that of the point in
/// the emission.
class Means {
 public:
  explicit Means(std::size_t points) : sum_(points, 0.0), time_(points, 0.0) {}

  void add(std::size_t point, double value, double time) {
    sum_.at(point) += value * time;
    time_.at(point) += time;
  }
  double operator[](std::size_t point) const {
    return time_.at(point) > 0.0 ? sum_.at(point) / time_.at(point) : 0.0;
  }

 private:
  std::vector<double> sum_, time_;
};

}  // namespace

SoundField::SoundField(ros::NodeHandle nh, ros::NodeHandle private_nh, ArrayModel model)
    : model_(std::move(model)),
      slice_height_(paramIn(private_nh, "slice_height", 0.0, 0.0, 1.0)),
      slice_size_(paramIn(private_nh, "slice_size", 0.16, 0.01, 1.0)),
      slice_step_(paramIn(private_nh, "slice_step", 0.004, 0.0005, 0.1)),
      skin_field_(param(private_nh, "skin_field", true)),
      slice_field_(param(private_nh, "slice_field", true)),
      inbox_(private_nh),
      nh_(nh) {
  const unsigned queue = param(private_nh, "lockstep", false) ? 0 : 1;
  drive_ = nh.advertise<ArrayDrive>(topic::array_drive, queue == 0 ? 0 : drive_queue);
  measured_ = nh.advertise<FocalPointArray>(topic::array_measured, queue);
  report_ = nh.advertise<AcousticReport>(topic::acoustics, queue);
  field_ = nh.advertise<sensor_msgs::PointCloud2>(topic::array_field, queue);
  geometry_ = nh.advertise<visualization_msgs::MarkerArray>(topic::array_geometry, 1, true);
  geometry_.publish(arrayMarkers(model_.layout));
}

void SoundField::publish(const Sound& sound, const std_msgs::Header& header) {
  publishDrive(sound, header);
  publishFields(sound, header);
}

void SoundField::publishDrive(const Sound& sound, const std_msgs::Header& header) {
  for (const auto& message : driveMessages(sound, model_.layout, header)) drive_.publish(message);
}

void SoundField::publishFields(const Sound& sound, const std_msgs::Header& header) {
  if (sound.parts.empty()) return;
  publishMeasured(sound, header);
  publishReport(sound, header);
  publishField(sound, header);
}

void SoundField::publishSilence(const std_msgs::Header& header) {
  publishDrive(Sound(), header);
}

/// Amplitudes at the points of a part, without skin. For many points in single precision, which is fast.
std::vector<double> SoundField::amplitudesAtPoints(const Sound::Part& part) const {
  constexpr std::size_t few = 16;
  std::vector<double> amplitudes;
  if (part.what.points.size() <= few) {
    for (const ultrasound::FocalPoint& point : part.what.points)
      amplitudes.push_back(
          std::abs(ultrasound::pressureAt(model_.layout, model_.acoustics, part.drive, point.position)));
    return amplitudes;
  }
  std::vector<Eigen::Vector3f> at;
  for (const ultrasound::FocalPoint& point : part.what.points) at.push_back(point.position.cast<float>());
  for (const auto& pressure : ultrasound::pressuresAt(model_.layout, model_.acoustics, part.drive, at))
    amplitudes.push_back(std::abs(pressure));
  return amplitudes;
}

void SoundField::publishMeasured(const Sound& sound, const std_msgs::Header& header) {
  Means pressures(sound.emission.points.size());
  for (const Sound::Part& part : sound.parts) {
    const std::vector<double> here = amplitudesAtPoints(part);
    for (std::size_t k = 0; k < here.size(); ++k) pressures.add(part.what.which[k], here[k], part.what.time);
  }
  auto message = boost::make_shared<FocalPointArray>();
  message->header = header;
  message->modulation = static_cast<std::uint8_t>(sound.emission.modulation);
  message->modulation_frequency = static_cast<float>(sound.emission.modulation_frequency);
  message->slip = static_cast<float>(sound.emission.slip);
  message->points = toMessage(sound.emission.points);
  for (std::size_t k = 0; k < message->points.size(); ++k)
    message->points[k].pressure = static_cast<float>(pressures[k]);
  measured_.publish(message);
}

void SoundField::publishReport(const Sound& sound, const std_msgs::Header& header) {
  if (report_.getNumSubscribers() == 0) return;
  auto message = boost::make_shared<AcousticReport>();
  message->header = header;
  Means achieved(sound.emission.points.size()), commanded(sound.emission.points.size());
  const auto points = slice(sound);
  const bool field = ultrasound::isField(sound.emission.modulation);
  for (const Sound::Part& part : sound.parts) {
    const std::vector<double> here = amplitudesAtPoints(part);
    std::vector<double> reached = here;
    if (field && ultrasound::knowSkin(part.what.points)) {
      const auto on_skin =
          ultrasound::amplitudesOnSkin(model_.layout, model_.acoustics, {part.drive}, part.what.points);
      reached.assign(on_skin.begin(), on_skin.end());
    }
    for (std::size_t k = 0; k < here.size(); ++k) {
      achieved.add(part.what.which[k], reached[k], part.what.time);
      if (!part.target.empty()) commanded.add(part.what.which[k], part.target[k], part.what.time);
    }
    const auto lobe = ultrasound::strongestSideLobe(
        points, ultrasound::pressuresAt(model_.layout, model_.acoustics, part.drive, points),
        part.what.points, here, 2.0 * model_.acoustics.wavelength());
    if (lobe.share > message->side_lobe) {
      message->side_lobe = static_cast<float>(lobe.share);
      message->side_lobe_position = tf2::toMsg(lobe.position);
    }
    message->head_spl =
        std::max(message->head_spl, static_cast<float>(ultrasound::headSpl(model_.layout, model_.acoustics,
                                                                           part.drive, model_.head_point)));
  }
  std::vector<double> all_achieved, all_commanded;
  for (std::size_t k = 0; k < sound.emission.points.size(); ++k) {
    message->id.push_back(sound.emission.points[k].id);
    all_achieved.push_back(achieved[k]);
    all_commanded.push_back(commanded[k]);
  }
  message->commanded.assign(all_commanded.begin(), all_commanded.end());
  message->achieved.assign(all_achieved.begin(), all_achieved.end());
  message->error = static_cast<float>(field ? ultrasound::fieldFit(all_commanded, all_achieved).error
                                            : ultrasound::relativeError(all_achieved, all_commanded));
  report_.publish(message);
}

std::vector<Eigen::Vector3f> SoundField::slice(const Sound& sound) const {
  double height = slice_height_;
  if (height == 0.0) {
    const auto strongest =
        std::max_element(sound.emission.points.begin(), sound.emission.points.end(),
                         [](const auto& a, const auto& b) { return a.intensity < b.intensity; });
    height = strongest == sound.emission.points.end() ? height_without_focus : strongest->position.z();
  }
  std::vector<Eigen::Vector3f> points;
  const int half = static_cast<int>(0.5 * slice_size_ / slice_step_);
  for (int row = -half; row <= half; ++row)
    for (int column = -half; column <= half; ++column)
      points.emplace_back(Eigen::Vector3d(column * slice_step_, row * slice_step_, height).cast<float>());
  return points;
}

std::vector<Eigen::Vector3f> SoundField::facingSkin() {
  if (!skin_subscriber_)
    skin_subscriber_ = inbox_.subscribe<sensor_msgs::PointCloud2>(
        nh_, topic::hands_skin, 1, [this](const sensor_msgs::PointCloud2::ConstPtr& skin) {
          skin_ = pressureSkin(*skin);
          skin_frame_ = skin->header.frame_id;
        });
  std::vector<Eigen::Vector3f> points;
  if (skin_.position.empty()) return points;
  const auto pose = transforms_.lookup(frame::array, skin_frame_);
  if (!pose) return points;
  const Eigen::Isometry3f to_array = pose->cast<float>();
  const auto& places = skin_.isTracked() ? skin_.position : skin_.tracked_position;
  const auto& normals = skin_.isTracked() ? skin_.normal : skin_.tracked_normal;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Eigen::Vector3f position = to_array * places[i];
    if (position.dot(to_array.linear() * normals[i]) < 0.0f) points.push_back(position);
  }
  return points;
}

void SoundField::publishField(const Sound& sound, const std_msgs::Header& header) {
  if (field_.getNumSubscribers() == 0) {
    skin_subscriber_.shutdown();
    skin_ = {};
    return;
  }
  std::vector<Eigen::Vector3f> points;
  if (skin_field_) points = facingSkin();
  if (slice_field_) {
    const auto plane = slice(sound);
    points.insert(points.end(), plane.begin(), plane.end());
  }
  std::vector<float> highest(points.size(), 0.0f);
  std::vector<double> power(points.size(), 0.0);  // mean of the squared amplitude
  for (const Sound::Part& part : sound.parts) {
    const auto pressures = ultrasound::pressuresAt(model_.layout, model_.acoustics, part.drive, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      highest[i] = std::max(highest[i], std::abs(pressures[i]));
      power[i] += part.what.power * std::norm(pressures[i]);
    }
  }
  CloudWriter cloud(header, "x y z pressure tactile", points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    cloud.vector(points[i]) << highest[i]
                            << static_cast<float>(
                                   ultrasound::radiationPressure(model_.acoustics, std::sqrt(power[i])));
  field_.publish(cloud.finish());
}

}  // namespace tactile_clay::nodes
