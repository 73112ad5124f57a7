#include "nodes/hand_markers.h"

#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>

#include "hand/anatomy.h"

namespace tactile_clay::nodes {
namespace {

using visualization_msgs::Marker;

struct Look {
  const char* name;
  float red, green, blue;
};
constexpr Look tracked_look = {"tracked", 0.10f, 0.25f, 0.80f};
constexpr Look virtual_look = {"virtual", 1.0f, 1.0f, 1.0f};
constexpr double bone_width = 0.0035, joint_width = 0.007, bead_distance = 0.0015;  // m

// Bones, too, are lists of spheres: rviz draws such a list as one object, but lines as flat ribbons.
enum Part { bone_part, joint_part };

Marker marker(const Look& look, hand::Side side, Part part, const std_msgs::Header& header) {
  Marker marker;
  marker.header = header;
  marker.ns = look.name;
  marker.id = 2 * static_cast<int>(side) + part;
  marker.type = Marker::SPHERE_LIST;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = part == bone_part ? bone_width : joint_width;
  marker.color.r = look.red;
  marker.color.g = look.green;
  marker.color.b = look.blue;
  marker.color.a = 1.0f;
  return marker;
}

template <class PositionOf>
void add(visualization_msgs::MarkerArray& markers, const Look& look, hand::Side side, PositionOf position,
         const std::bitset<hand::joint_count>& missing, const std_msgs::Header& header) {
  Marker bones = marker(look, side, bone_part, header), joints = marker(look, side, joint_part, header);
  for (int joint = 0; joint < hand::joint_count; ++joint) {
    if (joint == hand::palm || missing[joint]) continue;  // the palm lies between bones
    const Eigen::Vector3d to = position(joint), from = position(hand::joint_anatomy[joint].parent);
    joints.points.push_back(tf2::toMsg(to));
    const int beads = static_cast<int>(std::min(1000.0, (to - from).norm() / bead_distance));
    for (int k = 1; k < beads; ++k)
      bones.points.push_back(tf2::toMsg(Eigen::Vector3d(from + (to - from) * k / beads)));
  }
  markers.markers.push_back(bones);
  markers.markers.push_back(joints);
}

}  // namespace

void addBones(visualization_msgs::MarkerArray& markers, const hand::TrackedHand& tracked,
              const std::array<Eigen::Vector3d, hand::joint_count>& held, const std_msgs::Header& header) {
  add(
      markers, tracked_look, tracked.side, [&](int j) { return tracked.joints[j].position; }, tracked.missing,
      header);
  add(
      markers, virtual_look, tracked.side, [&](int j) { return held[j]; }, tracked.missing, header);
}

void removeBones(visualization_msgs::MarkerArray& markers, hand::Side side, const std_msgs::Header& header) {
  for (const Look& look : {tracked_look, virtual_look})
    for (const Part part : {bone_part, joint_part}) {
      Marker gone = marker(look, side, part, header);
      gone.action = Marker::DELETE;
      markers.markers.push_back(gone);
    }
}

}  // namespace tactile_clay::nodes
