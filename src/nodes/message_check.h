#pragma once

#include <ros/message_traits.h>
#include <sensor_msgs/PointCloud2.h>
#include <tactile_clay/FocalPointArray.h>
#include <tactile_clay/TrackedHands.h>

#include <string>

#include "nodes/stamps.h"

namespace tactile_clay::nodes {

/// What a message must be before a callback sees it: a stamp that can be reckoned with, a frame with a name
/// of ordinary length, and no more of anything than a node can work on, and keep, in its time.

/// Most of what messages may hold; more than the rig sends itself.
constexpr std::size_t max_frame_id = 256;          // characters
constexpr std::size_t max_hands = 64;              // of a frame
constexpr std::size_t max_cloud_points = 100'000;  // a soft hand has 4 000 samples of skin
constexpr std::size_t max_cloud_bytes = 16U << 20U;
constexpr std::size_t max_cloud_fields = 64;
constexpr std::size_t max_focal_points = 2048;  // or samples of a field, of which the renderer makes 2000
constexpr std::size_t max_waiting = 1000;  // messages of a lockstep run, in which one is on its way at a time

/// Empty, or what is wrong with a header, and what was expected.
std::string faultOfHeader(const ros::Time* stamp, const std::string* frame_id);

/// Empty, or what is wrong with a message, and what was expected.
template <class M>
std::string faultOf(const M& message) {
  return faultOfHeader(ros::message_traits::TimeStamp<M>::pointer(message),
                       ros::message_traits::FrameId<M>::pointer(message));
}
std::string faultOf(const TrackedHands& message);
std::string faultOf(const sensor_msgs::PointCloud2& message);
std::string faultOf(const FocalPointArray& message);

/// @throws std::runtime_error where a queue has no room for another message
void requireRoom(std::size_t waiting);

}  // namespace tactile_clay::nodes
