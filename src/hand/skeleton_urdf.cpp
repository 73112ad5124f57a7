#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "hand/hand_pose.h"
#include "hand/skeleton.h"
#include "hand/skeleton_joints.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

std::string text(const Vector3d& v) {
  std::ostringstream out;
  out.precision(9);
  out << v.x() << " " << v.y() << " " << v.z();
  return out.str();
}

// Origin of a URDF element: its turn as roll, pitch, yaw, R = Rz(yaw) Ry(pitch) Rx(roll).
std::string origin(const Vector3d& position, const Quaterniond& turn = Quaterniond::Identity()) {
  const Matrix3d r = turn.toRotationMatrix();
  const Vector3d rpy(std::atan2(r(2, 1), r(2, 2)), std::asin(std::clamp(-r(2, 0), -1.0, 1.0)),
                     std::atan2(r(1, 0), r(0, 0)));
  return "<origin xyz=\"" + text(position) + "\" rpy=\"" + text(rpy) + "\"/>";
}

void writeVisual(std::ostream& out, const std::string& where, const std::string& shape) {
  out << "    <visual>" << where << "<geometry>" << shape
      << "</geometry><material name=\"bone\"/></visual>\n";
}

// A bone, thinner than the flesh about it, between balls.
void writeBone(std::ostream& out, const Vector3d& from, const Vector3d& to, double radius) {
  const Vector3d along = to - from;
  std::ostringstream shaft, ball;
  shaft << "<cylinder radius=\"" << 0.3 * radius << "\" length=\"" << along.norm() << "\"/>";
  ball << "<sphere radius=\"" << 0.45 * radius << "\"/>";
  writeVisual(out, origin(0.5 * (from + to), Quaterniond::FromTwoVectors(Vector3d::UnitZ(), along)),
              shaft.str());
  writeVisual(out, origin(from), ball.str());
  writeVisual(out, origin(to), ball.str());
}

}  // namespace

std::string skeletonUrdf(const Skeleton& skeleton) {
  const bool left = skeleton.side == Side::left;
  const auto position = [left](const Vector3d& v) { return left ? mirrored(v) : v; };
  const auto radius = [&](Joint joint) { return joint_anatomy[joint].radius * skeleton.scale; };
  const std::string root = skeletonPrefix(skeleton.side) + "wrist";
  std::ostringstream out;
  out.precision(9);
  out << "<?xml version=\"1.0\"?>\n<robot name=\"" << (left ? "hand_left" : "hand_right")
      << "\">\n  <material name=\"bone\"><color rgba=\"0.15 0.3 0.75 1\"/></material>\n  <link name=\""
      << root << "\">\n";
  for (int f = 0; f < finger_count; ++f) {
    const Skeleton::Finger& finger = skeleton.fingers[f];
    writeBone(out, Vector3d::Zero(), position(finger.metacarpal), radius(little_proximal));
    if (f > 0) writeBone(out, position(finger.metacarpal), position(finger.root), radius(movingJoint(f, 0)));
  }
  out << "  </link>\n";
  std::string parent = root;
  for (int k = 0; k < skeleton_joint_count; ++k) {
    const JointPlace place = placeOf(k);
    const Skeleton::Finger& finger = skeleton.fingers[place.finger];
    const bool first = k == firstAngle(place.finger);
    const bool ends_bone = !place.abduction;  // flexion follows abduction
    if (first) parent = root;
    const std::string name = skeletonJointName(skeleton.side, k), link = name + "_link";
    // The next joint begins where a bone ends. The two angles of one joint are at one place.
    const bool new_place = !first && (place.abduction || !hasAbduction(place.finger, place.bone));
    const Vector3d shift = first       ? position(finger.root)
                           : new_place ? Vector3d(0.0, 0.0, -finger.bone[place.bone - 1])
                                       : Vector3d::Zero();
    const Quaterniond turn = !first ? Quaterniond::Identity()
                             : left ? mirrored(finger.straight)
                                    : finger.straight;
    const Vector3d axis = place.abduction ? Vector3d(0.0, left ? -1.0 : 1.0, 0.0) : Vector3d(-1.0, 0.0, 0.0);
    const Vector2d limit = skeletonLimits(k);
    const Vector3d end(0.0, 0.0, -finger.bone[place.bone]);
    out << "  <link name=\"" << link << "\">\n";
    if (ends_bone) writeBone(out, Vector3d::Zero(), end, radius(movingJoint(place.finger, place.bone + 1)));
    out << "  </link>\n  <joint name=\"" << name << "\" type=\"revolute\">\n    <parent link=\"" << parent
        << "\"/><child link=\"" << link << "\"/>\n    " << origin(shift, turn) << "\n    <axis xyz=\""
        << text(axis) << "\"/>\n    <limit lower=\"" << limit[0] << "\" upper=\"" << limit[1]
        << "\" effort=\"10\" velocity=\"20\"/>\n  </joint>\n";
    parent = link;
    if (place.bone != bone_count - 1) continue;
    const std::string tip = skeletonPrefix(skeleton.side) + skeletonFinger(place.finger) + "_tip";
    out << "  <link name=\"" << tip << "\"/>\n  <joint name=\"" << tip
        << "_joint\" type=\"fixed\">\n    <parent link=\"" << parent << "\"/><child link=\"" << tip
        << "\"/>\n    " << origin(end) << "\n  </joint>\n";
  }
  out << "</robot>\n";
  return out.str();
}

}  // namespace tactile_clay::hand
