#include "nodes/hand_sources/leap_motion_message.h"

#include <geometry_msgs/Pose.h>

#include <string>

namespace ros::serialization {
namespace {

using Human = tactile_clay::nodes::LeapMotionHuman;

template <typename T>
T next(IStream& stream) {
  T value{};
  stream.next(value);
  return value;
}

// Skips a list that is not used, without reading it: with a wrong length, reading would ask for all memory.
template <typename T>
void skipList(IStream& stream) {
  const auto count = next<std::uint32_t>(stream);
  if (count > stream.getLength() / sizeof(T)) throwStreamOverrun();
  stream.advance(count * static_cast<std::uint32_t>(sizeof(T)));
}

// Skips fields that are not used.
template <typename... T>
void skip(IStream& stream) {
  (static_cast<void>(next<T>(stream)), ...);
}

template <typename T, typename Read>
std::vector<T> list(IStream& stream, const Read& read) {
  std::vector<T> items;
  // One item at a time: a wrong length then allocates nothing in advance, and the end of the stream throws an
  // exception.
  for (auto left = next<std::uint32_t>(stream); left > 0; --left) items.push_back(read(stream));
  return items;
}

Human::Bone readBone(IStream& stream) {
  Human::Bone bone;
  skip<std_msgs::Header>(stream);
  bone.type = next<std::uint8_t>(stream);
  skip<float, float, std::string>(stream);  // length, width, to_string
  bone.start = next<geometry_msgs::Pose>(stream).position;
  bone.end = next<geometry_msgs::Pose>(stream).position;
  skipList<float>(stream);  // centre
  return bone;
}

Human::Finger readFinger(IStream& stream) {
  Human::Finger finger;
  skip<std_msgs::Header, std::int32_t>(stream);  // id
  finger.type = next<std::uint8_t>(stream);
  skip<float, float, std::string>(stream);  // length, width, to_string
  finger.bones = list<Human::Bone>(stream, readBone);
  return finger;
}

bool skipGesture(IStream& stream) {
  skip<std::int32_t, std::uint8_t, std::int64_t, float, std::int32_t, std::int32_t, std::string>(stream);
  skipList<std::int32_t>(stream);
  return true;
}

Human::Hand readHand(IStream& stream) {
  Human::Hand hand;
  skip<std_msgs::Header>(stream);
  hand.id = next<std::int32_t>(stream);
  hand.present = next<std::uint8_t>(stream) != 0;
  skip<std::uint8_t, float>(stream);  // valid_gestures, time_visible
  hand.confidence = next<float>(stream);
  skip<float, float, float>(stream);  // roll, pitch, yaw
  hand.direction = next<geometry_msgs::Vector3>(stream);
  hand.normal = next<geometry_msgs::Vector3>(stream);
  skip<float, float>(stream);  // grab and pinch strength
  skipList<float>(stream);     // palm velocity
  hand.palm = next<geometry_msgs::Point>(stream);
  skip<float, float>(stream);  // palm width, sphere
  skipList<float>(stream);     // and its centre
  skip<std::string>(stream);   // to_string
  hand.fingers = list<Human::Finger>(stream, readFinger);
  list<bool>(stream, skipGesture);
  skip<std_msgs::Header, geometry_msgs::Pose>(stream);  // arm: elbow
  hand.wrist = next<geometry_msgs::Pose>(stream).position;
  skipList<float>(stream);               // centre
  skip<geometry_msgs::Vector3>(stream);  // direction
  return hand;
}

}  // namespace

void Serializer<Human>::read(IStream& stream, Human& human) {
  human.header = next<std_msgs::Header>(stream);
  // Frame id, numbers of hands, fingers and gestures, rate, to_string
  skip<std::int32_t, std::int32_t, std::int32_t, std::int32_t, float, std::string>(stream);
  human.right = readHand(stream);
  human.left = readHand(stream);
}

}  // namespace ros::serialization
