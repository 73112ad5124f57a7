#include "nodes/conversions.h"

#include <tf2_eigen/tf2_eigen.h>

#include <cmath>
#include <optional>
#include <stdexcept>

#include "nodes/cloud.h"
#include "nodes/frame_name.h"
#include "ultrasound/felt_force.h"
#include "ultrasound/perceptual_weight.h"

namespace tactile_clay::nodes {
namespace {

template <typename T>
struct Columns3 {
  Columns3(const sensor_msgs::PointCloud2& cloud, const char* x, const char* y, const char* z)
      : x_(column<T>(cloud, x)), y_(column<T>(cloud, y)), z_(column<T>(cloud, z)) {}
  Eigen::Matrix<T, 3, 1> operator[](std::size_t i) const { return {x_[i], y_[i], z_[i]}; }

 private:
  Column<T> x_, y_, z_;
};

using Vectors = Columns3<float>;

Vectors positions(const sensor_msgs::PointCloud2& cloud) {
  return {cloud, "x", "y", "z"};
}
Vectors normals(const sensor_msgs::PointCloud2& cloud) {
  return {cloud, "normal_x", "normal_y", "normal_z"};
}

/// Sliding speed of the clay, m/s. The clay of another program may leave it out: then nothing slides.
std::optional<Column<float>> slips(const sensor_msgs::PointCloud2& cloud) {
  if (!hasField(cloud, "slip")) return std::nullopt;
  return column<float>(cloud, "slip");
}

/// Further fields of hands/skin if it is not the skin of the tracked hand itself.
constexpr char tracked_fields[] =
    "tracked_x tracked_y tracked_z tracked_normal_x tracked_normal_y tracked_normal_z tracked_area";

/// Colour in the bits of a float, as PCL and rviz read the field `rgb`.
float packed(const Eigen::Vector3f& color) {
  std::uint32_t bits = 0;
  for (int c = 0; c < 3; ++c)
    bits = bits << 8 |
           static_cast<std::uint32_t>(std::lround(255.0f * std::min(std::max(color[c], 0.0f), 1.0f)));
  float value;
  std::memcpy(&value, &bits, 4);
  return value;
}

}  // namespace

TrackedHands toMessage(const hand::TrackedFrame& frame) {
  TrackedHands message;
  message.header.stamp = toRos(frame.stamp);
  message.header.frame_id = frame.frame_id;
  for (const hand::TrackedHand& hand : frame.hands) {
    TrackedHand& out = message.hands.emplace_back();
    out.id = hand.id;
    out.side = static_cast<std::uint8_t>(hand.side);
    out.confidence = static_cast<float>(hand.confidence);
    for (std::size_t j = 0; j < hand.joints.size(); ++j) {
      const hand::JointPose joint =
          hand.missing[j]
              ? hand::JointPose{hand.joints[hand::wrist].position, hand.joints[hand::wrist].orientation, 0.0}
              : hand.joints[j];
      out.joints[j].position = tf2::toMsg(joint.position);
      out.joints[j].orientation = tf2::toMsg(joint.orientation);
      out.radii[j] = static_cast<float>(joint.radius);
    }
  }
  return message;
}

hand::TrackedFrame toCore(const TrackedHands& message) {
  hand::TrackedFrame frame;
  frame.stamp = toCore(message.header.stamp);
  frame.frame_id = frameName(message.header.frame_id);
  for (const TrackedHand& hand : message.hands) {
    hand::TrackedHand& out = frame.hands.emplace_back();
    out.id = hand.id;
    out.side = static_cast<hand::Side>(hand.side);  // unchecked: hand_check reports a wrong one
    out.confidence = hand.confidence;
    for (std::size_t j = 0; j < out.joints.size(); ++j) {
      tf2::fromMsg(hand.joints[j].position, out.joints[j].position);
      tf2::fromMsg(hand.joints[j].orientation, out.joints[j].orientation);
      out.joints[j].radius = hand.radii[j];
    }
  }
  return frame;
}

sensor_msgs::PointCloud2Ptr skinCloud(const Skin& skin, const std_msgs::Header& header) {
  const bool beside = !skin.tracked_position.empty();
  CloudWriter cloud(header,
                    std::string("x y z normal_x normal_y normal_z vx vy vz area hand:u region:u weight "
                                "pad_distance ") +
                        (beside ? tracked_fields : ""),
                    skin.size());
  for (std::size_t i = 0; i < skin.size(); ++i) {
    cloud.vector(skin.position[i]).vector(skin.normal[i]).vector(skin.velocity[i])
        << skin.area[i] << std::uint32_t{skin.side[i]} << std::uint32_t{skin.region[i]}
        << static_cast<float>(ultrasound::perceptualWeight(skin.pad_distance[i])) << skin.pad_distance[i];
    if (beside) cloud.vector(skin.tracked_position[i]).vector(skin.tracked_normal[i]) << skin.tracked_area[i];
  }
  return cloud.finish();
}

Skin claySkin(const sensor_msgs::PointCloud2& skin, std::size_t maximum) {
  if (const std::size_t count = pointCount(skin); count > maximum)
    throw std::runtime_error(std::to_string(count) + " samples, expected at most " + std::to_string(maximum) +
                             " of this clay");
  const Vectors position = positions(skin), normal = normals(skin), velocity(skin, "vx", "vy", "vz");
  Skin samples;
  for (std::size_t i = 0, n = pointCount(skin); i < n; ++i) {
    samples.position.push_back(position[i]);
    samples.normal.push_back(normal[i]);
    samples.velocity.push_back(velocity[i]);
    if (!samples.position[i].allFinite() || !samples.normal[i].allFinite() ||
        !samples.velocity[i].allFinite())
      throw std::runtime_error("skin sample " + std::to_string(i) + ": expected finite numbers");
  }
  return samples;
}

Skin pressureSkin(const sensor_msgs::PointCloud2& skin) {
  const Vectors position = positions(skin), normal = normals(skin);
  const auto area = column<float>(skin, "area"), weight = column<float>(skin, "weight");
  Skin out;
  for (std::size_t i = 0, n = pointCount(skin); i < n; ++i) {
    out.position.push_back(position[i]);
    out.normal.push_back(normal[i]);
    out.area.push_back(area[i]);
    out.weight.push_back(weight[i]);
  }
  if (!hasField(skin, "tracked_x")) return out;
  const Vectors place(skin, "tracked_x", "tracked_y", "tracked_z"),
      direction(skin, "tracked_normal_x", "tracked_normal_y", "tracked_normal_z");
  const auto bare = column<float>(skin, "tracked_area");
  for (std::size_t i = 0; i < out.position.size(); ++i) {
    out.tracked_position.push_back(place[i]);
    out.tracked_normal.push_back(direction[i]);
    out.tracked_area.push_back(bare[i]);
  }
  return out;
}

sensor_msgs::PointCloud2Ptr particleCloud(const clay::Clay& clay, const scene::Scene& scene,
                                          const std_msgs::Header& header) {
  const clay::Particles& particles = clay.particles();
  std::vector<float> color;
  for (const scene::Body& body : scene.bodies) color.push_back(packed(body.color));
  std::vector<float> rest_density;
  for (const clay::Material& material : clay.materials())
    rest_density.push_back(static_cast<float>(material.density));

  CloudWriter cloud(header, "x y z rgb vx vy vz density body:u", particles.size());
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const float density = particles.density_ratio[i] * rest_density.at(particles.material[i]);
    cloud.vector(particles.position.at(i)) << color.at(particles.body[i]);
    cloud.vector(particles.velocity.at(i)) << density << std::uint32_t{particles.body[i]};
  }
  return cloud.finish();
}

sensor_msgs::PointCloud2Ptr contactCloud(const std::vector<SkinForce>& forces, const Skin& samples,
                                         const sensor_msgs::PointCloud2& skin) {
  // The skin of another program may leave these fields out.
  const bool told = hasColumn<std::uint32_t>(skin, "hand") && hasColumn<std::uint32_t>(skin, "region") &&
                    hasColumn<float>(skin, "area");
  std::optional<Vectors> velocity;
  if (!forces.empty()) velocity.emplace(skin, "vx", "vy", "vz");  // else the skin may be unreadable
  std::optional<Column<std::uint32_t>> hand, region;
  std::optional<Column<float>> area;
  if (told) {
    hand = column<std::uint32_t>(skin, "hand");
    region = column<std::uint32_t>(skin, "region");
    area = column<float>(skin, "area");
  }
  CloudWriter cloud(
      skin.header,
      std::string("x y z fx fy fz index:u vx vy vz slip") + (told ? " hand:u region:u area" : ""),
      forces.size());
  for (const SkinForce& force : forces) {
    cloud.vector(samples.position.at(force.index)).vector(force.force) << force.index;
    cloud.vector((*velocity)[force.index]) << force.slip;
    if (told) cloud << (*hand)[force.index] << (*region)[force.index] << (*area)[force.index];
  }
  return cloud.finish();
}

std::vector<SkinForce> contactForces(const sensor_msgs::PointCloud2& contacts) {
  const Vectors force(contacts, "fx", "fy", "fz");
  const auto index = column<std::uint32_t>(contacts, "index");
  const auto slip = slips(contacts);
  std::vector<SkinForce> out;
  for (std::size_t i = 0, n = pointCount(contacts); i < n; ++i)
    out.push_back({index[i], force[i], slip ? (*slip)[i] : 0.0f});
  return out;
}

bool onSkin(const sensor_msgs::PointCloud2& contacts, const Skin& skin) {
  if (!hasField(contacts, "x")) return true;
  constexpr float same_place = 1e-3f;  // m; the clay sends the positions of the skin back unchanged
  const Vectors place = positions(contacts);
  const auto index = column<std::uint32_t>(contacts, "index");
  for (std::size_t i = 0, n = pointCount(contacts); i < n; ++i)
    if (index[i] >= skin.position.size() || !((place[i] - skin.position[index[i]]).norm() < same_place))
      return false;
  return true;
}

sensor_msgs::PointCloud2Ptr pressureCloud(const std::vector<contact::PressureSample>& samples,
                                          const std_msgs::Header& header) {
  CloudWriter cloud(header, "x y z normal_x normal_y normal_z pressure force area weight slip",
                    samples.size());
  for (const contact::PressureSample& sample : samples)
    cloud.vector(sample.position).vector(sample.normal)
        << sample.pressure << sample.force << sample.area << sample.weight << sample.slip;
  return cloud.finish();
}

std::vector<contact::PressureSample> pressureSamples(const sensor_msgs::PointCloud2& pressure) {
  const Vectors position = positions(pressure), normal = normals(pressure);
  const auto p = column<float>(pressure, "pressure"), force = column<float>(pressure, "force"),
             area = column<float>(pressure, "area"), weight = column<float>(pressure, "weight");
  const auto slip = slips(pressure);
  std::vector<contact::PressureSample> out;
  for (std::size_t i = 0, n = pointCount(pressure); i < n; ++i)
    out.push_back({position[i], normal[i], p[i], force[i], area[i], weight[i], slip ? (*slip)[i] : 0.0f});
  return out;
}

std::vector<FocalPoint> toMessage(const std::vector<ultrasound::FocalPoint>& points) {
  std::vector<FocalPoint> out;
  for (const ultrasound::FocalPoint& point : points) {
    FocalPoint& message = out.emplace_back();
    message.id = point.id;
    message.position = tf2::toMsg(point.position);
    message.pressure = static_cast<float>(point.pressure);
    message.intensity = static_cast<float>(point.intensity);
  }
  return out;
}

std::vector<ultrasound::FocalPoint> toCore(const std::vector<FocalPoint>& points) {
  std::vector<ultrasound::FocalPoint> out;
  for (const FocalPoint& point : points)
    out.push_back(
        {point.id, {point.position.x, point.position.y, point.position.z}, point.pressure, point.intensity});
  return out;
}

std::vector<geometry_msgs::Vector3> normalsOf(const std::vector<ultrasound::FocalPoint>& samples) {
  std::vector<geometry_msgs::Vector3> out;
  for (const ultrasound::FocalPoint& sample : samples) tf2::toMsg(sample.normal, out.emplace_back());
  return out;
}

RenderingReport toMessage(const ultrasound::RenderReport& report, double compression_knee) {
  RenderingReport out;
  out.gain = static_cast<float>(report.gain);
  out.compression_knee = static_cast<float>(compression_knee);
  out.compressed_points = static_cast<std::uint32_t>(report.compressed_points);
  out.saturated_points = static_cast<std::uint32_t>(report.saturated_points);
  out.merged_points = static_cast<std::uint32_t>(report.merged_points);
  out.raised_points = static_cast<std::uint32_t>(report.raised_points);
  out.ignored_samples = static_cast<std::uint32_t>(report.ignored_samples);
  out.wanted.assign(report.wanted.begin(), report.wanted.end());
  out.granted.assign(report.granted.begin(), report.granted.end());
  out.error = static_cast<float>(report.error);
  out.weighted_error = static_cast<float>(report.weighted_error);
  return out;
}

void tellForce(const FocalPointArray& points, RenderingReport& report) {
  if (points.area.size() != report.granted.size()) return;  // not known
  double force = 0.0;
  for (std::size_t k = 0; k < points.area.size(); ++k)
    force += static_cast<double>(points.area[k]) * report.granted[k];
  // Only one place of a path sounds at a time.
  const auto modulation = static_cast<ultrasound::Modulation>(points.modulation);
  if (modulation == ultrasound::Modulation::spatiotemporal && !points.area.empty())
    force /= static_cast<double>(points.area.size());
  const ultrasound::FeltForce felt = ultrasound::feltForce(modulation, points.modulation_frequency, force);
  constexpr double milli = 1e3;
  report.force = static_cast<float>(milli * force);
  report.vibration = static_cast<float>(felt.vibration);
  report.static_force = static_cast<float>(milli * felt.pressure);
}

}  // namespace tactile_clay::nodes
