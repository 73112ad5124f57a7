#include "nodes/surface_markers.h"

#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>
#include <cstring>

#include "nodes/cloud.h"

namespace tactile_clay::nodes {
namespace {

const Daylight daylight;

/// Colour in the bits of a float, as PCL and rviz read the field `rgb`.
Eigen::Vector3f unpacked(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, 4);
  return Eigen::Vector3f(static_cast<float>(bits >> 16 & 255u), static_cast<float>(bits >> 8 & 255u),
                         static_cast<float>(bits & 255u)) /
         255.0f;
}

}  // namespace

SurfaceParticles surfaceParticles(const sensor_msgs::PointCloud2& particles) {
  const auto x = column<float>(particles, "x"), y = column<float>(particles, "y"),
             z = column<float>(particles, "z"), color = column<float>(particles, "rgb");
  SurfaceParticles out;
  const std::size_t n = pointCount(particles);
  out.position.resize(n);
  out.color.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    out.position.set(i, {x[i], y[i], z[i]});
    out.color[i] = unpacked(color[i]);
  }
  return out;
}

Eigen::Vector3f lit(const Eigen::Vector3f& color, const Eigen::Vector3f& normal) {
  const Daylight& from = daylight;
  const float light = from.from_below + from.from_sky * 0.5f * (1.0f + normal.z()) +
                      from.from_sun * std::max(0.0f, normal.dot(from.sun)) +
                      from.from_fill * std::max(0.0f, normal.dot(from.fill));
  return (light * color).cwiseMin(1.0f);
}

std::vector<Eigen::Vector3f> lit(const surface::TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> colors(mesh.position.size());
  for (std::size_t i = 0; i < colors.size(); ++i) colors[i] = lit(mesh.color[i], mesh.normal[i]);
  return colors;
}

visualization_msgs::Marker surfaceMarker(const surface::TriangleMesh& mesh,
                                         const std::vector<Eigen::Vector3f>& colors,
                                         const std::vector<std::array<std::uint32_t, 3>>& triangles,
                                         float alpha, const std_msgs::Header& header, const std::string& name,
                                         int id) {
  using visualization_msgs::Marker;
  Marker marker;
  marker.header = header;
  marker.ns = name;
  marker.id = id;
  marker.type = Marker::TRIANGLE_LIST;
  marker.action = triangles.empty() ? Marker::DELETE : Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  marker.color.r = marker.color.g = marker.color.b = marker.color.a = 1.0f;
  marker.points.reserve(3 * triangles.size());
  marker.colors.reserve(3 * triangles.size());
  for (const auto& triangle : triangles) {
    for (const std::uint32_t corner : triangle) {
      marker.points.push_back(tf2::toMsg(Eigen::Vector3d(mesh.position[corner].cast<double>())));
      std_msgs::ColorRGBA& color = marker.colors.emplace_back();
      color.r = colors[corner].x();
      color.g = colors[corner].y();
      color.b = colors[corner].z();
      color.a = alpha;
    }
  }
  return marker;
}

}  // namespace tactile_clay::nodes
