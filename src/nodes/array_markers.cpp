#include "nodes/array_markers.h"

#include <boost/make_shared.hpp>
#include <limits>

#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

constexpr double board_thickness = 0.004, transducer_height = 0.007;  // m

visualization_msgs::Marker marker(int id, int type, float grey) {
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
  Marker transducers = marker(1, Marker::SPHERE_LIST, 0.75f);
  transducers.scale.x = transducers.scale.y = 0.85 * layout.pitch;
  transducers.scale.z = transducer_height;
  for (const Eigen::Vector3d& position : layout.position) {
    low = low.cwiseMin(position);
    high = high.cwiseMax(position);
    geometry_msgs::Point& point = transducers.points.emplace_back();
    point.x = position.x();
    point.y = position.y();
    point.z = position.z() - 0.5 * transducer_height;
  }
  Marker board = marker(0, Marker::CUBE, 0.15f);
  board.pose.position.x = 0.5 * (low.x() + high.x());
  board.pose.position.y = 0.5 * (low.y() + high.y());
  board.pose.position.z = low.z() - transducer_height - 0.5 * board_thickness;
  board.scale.x = high.x() - low.x() + 2.0 * layout.pitch;
  board.scale.y = high.y() - low.y() + 2.0 * layout.pitch;
  board.scale.z = board_thickness;
  auto markers = boost::make_shared<visualization_msgs::MarkerArray>();
  markers->markers = {board, transducers};
  return markers;
}

}  // namespace tactile_clay::nodes
