#include "nodes/array_markers.h"

#include <tf2_eigen/tf2_eigen.h>

#include <boost/make_shared.hpp>
#include <limits>
#include <stdexcept>
#include <string>

#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

constexpr double board_thickness = 0.004, transducer_height = 0.007;  // m
constexpr double direction_length = 0.004, direction_width = 0.0002;  // m
constexpr char directions[] = "directions of the transducers";

visualization_msgs::Marker greyMarker(int id, int type, float grey) {
  visualization_msgs::Marker marker;
  marker.header.frame_id = frame::array;
  marker.ns = "array";
  marker.id = id;
  marker.type = type;
  marker.pose.orientation.w = 1.0;
  marker.color.r = marker.color.g = marker.color.b = grey;
  marker.color.a = 1.0f;
  marker.frame_locked = true;
  return marker;
}

}  // namespace

visualization_msgs::MarkerArrayPtr arrayMarkers(const ultrasound::ArrayLayout& layout) {
  using visualization_msgs::Marker;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::max()), high = -low;
  Marker transducers = greyMarker(1, Marker::SPHERE_LIST, 0.75f);
  transducers.scale.x = transducers.scale.y = 0.85 * layout.pitch;
  transducers.scale.z = transducer_height;
  const Eigen::Vector3d below_face(0.0, 0.0, 0.5 * transducer_height);
  for (const Eigen::Vector3d& position : layout.position) {
    low = low.cwiseMin(position);
    high = high.cwiseMax(position);
    transducers.points.push_back(tf2::toMsg(Eigen::Vector3d(position - below_face)));
  }
  Marker board = greyMarker(0, Marker::CUBE, 0.15f);
  board.pose.position.x = 0.5 * (low.x() + high.x());
  board.pose.position.y = 0.5 * (low.y() + high.y());
  board.pose.position.z = low.z() - transducer_height - 0.5 * board_thickness;
  board.scale.x = high.x() - low.x() + 2.0 * layout.pitch;
  board.scale.y = high.y() - low.y() + 2.0 * layout.pitch;
  board.scale.z = board_thickness;
  Marker lines = greyMarker(2, Marker::LINE_LIST, 0.75f);
  lines.ns = directions;
  lines.scale.x = direction_width;
  for (std::size_t n = 0; n < layout.size(); ++n) {
    for (const double from_face : {-direction_length, 0.0}) {
      const Eigen::Vector3d at = layout.position[n] + from_face * layout.normal[n];
      lines.points.push_back(tf2::toMsg(at));
    }
  }
  auto markers = boost::make_shared<visualization_msgs::MarkerArray>();
  markers->markers = {board, transducers, lines};
  return markers;
}

ultrasound::ArrayLayout layoutOf(const visualization_msgs::MarkerArray& markers) {
  ultrasound::ArrayLayout layout;
  for (const visualization_msgs::Marker& marker : markers.markers) {
    if (marker.ns != directions) continue;
    for (std::size_t k = 0; k + 1 < marker.points.size(); k += 2) {
      const geometry_msgs::Point &within = marker.points[k], &face = marker.points[k + 1];
      layout.position.emplace_back(face.x, face.y, face.z);
      const Eigen::Vector3d way = layout.position.back() - Eigen::Vector3d(within.x, within.y, within.z);
      if (!way.allFinite() || !(way.norm() > 0.0)) throw std::runtime_error("a transducer has no direction");
      layout.normal.push_back(way.normalized());
    }
  }
  if (layout.position.empty())
    throw std::runtime_error("no markers '" + std::string(directions) +
                             "', expected those that array nodes publish on array/geometry");
  return layout;
}

}  // namespace tactile_clay::nodes
