#include "nodes/message_check.h"

#include <stdexcept>

#include "nodes/cloud.h"

namespace tactile_clay::nodes {
namespace {

std::string tooMany(std::size_t count, const char* what, std::size_t maximum) {
  return std::to_string(count) + " " + what + ", expected at most " + std::to_string(maximum);
}

}  // namespace

std::string faultOfHeader(const ros::Time* stamp, const std::string* frame_id) {
  std::string fault = stamp != nullptr ? faultOf(*stamp) : "";
  if (fault.empty() && frame_id != nullptr && frame_id->size() > max_frame_id)
    fault = "frame with a name of " + tooMany(frame_id->size(), "characters", max_frame_id);
  return fault;
}

std::string faultOf(const TrackedHands& message) {
  if (message.hands.size() > max_hands) return tooMany(message.hands.size(), "hands", max_hands);
  return faultOfHeader(&message.header.stamp, &message.header.frame_id);
}

std::string faultOf(const sensor_msgs::PointCloud2& message) {
  const std::size_t points = std::size_t{message.width} * message.height;
  if (points > max_cloud_points) return "cloud of " + tooMany(points, "points", max_cloud_points);
  if (message.data.size() > max_cloud_bytes)
    return "cloud of " + tooMany(message.data.size(), "bytes", max_cloud_bytes);
  if (message.fields.size() > max_cloud_fields)
    return "cloud with " + tooMany(message.fields.size(), "fields", max_cloud_fields);
  return faultOfHeader(&message.header.stamp, &message.header.frame_id);
}

std::string faultOf(const FocalPointArray& message) {
  if (message.points.size() > max_focal_points)
    return tooMany(message.points.size(), "focal points", max_focal_points);
  return faultOfHeader(&message.header.stamp, &message.header.frame_id);
}

void requireRoom(std::size_t waiting) {
  if (waiting >= max_waiting)
    throw std::runtime_error(tooMany(waiting + 1, "messages that wait in lockstep", max_waiting));
}

}  // namespace tactile_clay::nodes
