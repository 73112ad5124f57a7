#include "nodes/color_bar.h"

#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "nodes/surface_markers.h"

namespace tactile_clay::nodes {
namespace {

using Eigen::Vector3f;
using visualization_msgs::Marker;

/// Colours at equal distances from 0 to the full scale.
const std::array<Vector3f, 4> stops = {Vector3f(1.0f, 0.93f, 0.45f), Vector3f(1.0f, 0.62f, 0.10f),
                                       Vector3f(0.86f, 0.14f, 0.16f), Vector3f(0.38f, 0.0f, 0.22f)};

Marker label(const std_msgs::Header& header, const std::string& name, int id, const Vector3f& at,
             const std::string& text) {
  Marker marker;
  marker.header = header;
  marker.ns = name;
  marker.id = id;
  marker.type = Marker::TEXT_VIEW_FACING;
  marker.pose.position = tf2::toMsg(Eigen::Vector3d(at.cast<double>()));
  marker.pose.orientation.w = 1.0;
  marker.scale.z = 0.012;
  marker.color.r = marker.color.g = marker.color.b = 0.1f;
  marker.color.a = 1.0f;
  marker.text = text;
  return marker;
}

}  // namespace

Vector3f pressureColor(float share) {
  const float at = 3.0f * std::clamp(share, 0.0f, 1.0f);
  const int below = std::min(2, static_cast<int>(at));
  const float t = at - static_cast<float>(below);
  return (1.0f - t) * stops[below] + t * stops[below + 1];
}

void addColorBar(visualization_msgs::MarkerArray& markers, const ColorBar& wanted, const std::string& frame) {
  constexpr int pieces = 48, numbers = 5, first = 10;  // first id; other markers of this name have lower ones
  std_msgs::Header header;
  header.frame_id = frame;
  surface::TriangleMesh bar;
  for (int k = 0; k <= pieces; ++k) {
    const float share = static_cast<float>(k) / pieces;
    for (const float side : {-0.5f, 0.5f}) {
      bar.position.push_back(wanted.foot + side * wanted.width + share * wanted.height);
      bar.color.push_back(pressureColor(share));
    }
    if (k == 0) continue;
    const auto n = static_cast<std::uint32_t>(2 * k);
    bar.triangles.push_back({n - 2, n - 1, n});
    bar.triangles.push_back({n - 1, n + 1, n});
  }
  markers.markers.push_back(surfaceMarker(bar, bar.color, bar.triangles, 1.0f, header, wanted.name, first));
  for (int k = 0; k < numbers; ++k) {
    const float share = static_cast<float>(k) / (numbers - 1);
    char text[32];
    std::snprintf(text, sizeof text, "%g", wanted.full_scale * static_cast<double>(share));
    markers.markers.push_back(label(header, wanted.name, first + 1 + k,
                                    wanted.foot + 1.5f * wanted.width + share * wanted.height, text));
  }
  markers.markers.push_back(label(header, wanted.name, first + 1 + numbers, wanted.title_at, wanted.title));
}

}  // namespace tactile_clay::nodes
