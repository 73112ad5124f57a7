#pragma once

#include <geometry_msgs/Point.h>
#include <geometry_msgs/Vector3.h>
#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/message_check.h"

namespace tactile_clay::nodes {

/// The part of a `leap_motion/Human` of ros-drivers/leap_motion that is used: m, in Leap's axes (x along the
/// device, y up, z to the user). It is decoded here from the bytes of that message, so that the package
/// itself is not needed.
struct LeapMotionHuman {
  struct Bone {
    std::uint8_t type = 0;  // 0 metacarpal to 3 distal
    geometry_msgs::Point start, end;
  };
  struct Finger {
    std::uint8_t type = 0;  // 0 thumb to 4 little
    std::vector<Bone> bones;
  };
  struct Hand {
    std::int32_t id = 0;
    bool present = false;
    float confidence = 0.0F;
    geometry_msgs::Vector3 direction, normal;
    geometry_msgs::Point palm, wrist;
    std::vector<Finger> fingers;
  };

  std_msgs::Header header;
  Hand right, left;
};

/// Empty, or what is wrong with the message, and what was expected.
inline std::string faultOf(const LeapMotionHuman& message) {
  return faultOfHeader(&message.header.stamp, nullptr);
}

}  // namespace tactile_clay::nodes

namespace ros::message_traits {
template <>
struct MD5Sum<tactile_clay::nodes::LeapMotionHuman> {
  static const char* value() { return "2817a017ab58b244566892058c4f6e6d"; }
  static const char* value(const tactile_clay::nodes::LeapMotionHuman&) { return value(); }
};
template <>
struct DataType<tactile_clay::nodes::LeapMotionHuman> {
  static const char* value() { return "leap_motion/Human"; }
  static const char* value(const tactile_clay::nodes::LeapMotionHuman&) { return value(); }
};
}  // namespace ros::message_traits

namespace ros::serialization {
/// Only reads: nobody sends this message here.
template <>
struct Serializer<tactile_clay::nodes::LeapMotionHuman> {
  static void read(IStream& stream, tactile_clay::nodes::LeapMotionHuman& human);
};
}  // namespace ros::serialization
