#include "nodes/message_check.h"

#include <stdexcept>

#include "nodes/cloud.h"

namespace tactile_clay::nodes {
namespace {

std::string tooMany(std::size_t count, const char* what, std::size_t most) {
  return std::to_string(count) + " " + what + ", expected at most " + std::to_string(most);
}

}  // namespace

std::string faultOfHeader(const ros::Time* stamp, const std::string* frame_id) {
  std::string fault = stamp != nullptr ? faultOf(*stamp) : "";
  if (fault.empty() && frame_id != nullptr && frame_id->size() > most_frame_id)
    fault = "frame with a name of " + tooMany(frame_id->size(), "characters", most_frame_id);
  return fault;
}

std::string faultOf(const TrackedHands& message) {
  if (message.hands.size() > most_hands) return tooMany(message.hands.size(), "hands", most_hands);
  return faultOfHeader(&message.header.stamp, &message.header.frame_id);
}

std::string faultOf(const sensor_msgs::PointCloud2& message) {
  const std::size_t points = std::size_t{message.width} * message.height;
  if (points > most_cloud_points) return "cloud of " + tooMany(points, "points", most_cloud_points);
  if (message.data.size() > most_cloud_bytes)
    return "cloud of " + tooMany(message.data.size(), "bytes", most_cloud_bytes);
  if (message.fields.size() > most_cloud_fields)
    return "cloud with " + tooMany(message.fields.size(), "fields", most_cloud_fields);
  return faultOfHeader(&message.header.stamp, &message.header.frame_id);
}

std::string faultOf(const FocalPointArray& message) {
  if (message.points.size() > most_focal_points)
    return tooMany(message.points.size(), "focal points", most_focal_points);
  return faultOfHeader(&message.header.stamp, &message.header.frame_id);
}

void requireRoom(std::size_t waiting) {
  if (waiting >= most_waiting)
    throw std::runtime_error(tooMany(waiting + 1, "messages that wait in lockstep", most_waiting));
}

}  // namespace tactile_clay::nodes
