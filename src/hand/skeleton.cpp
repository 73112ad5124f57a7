#include "hand/skeleton.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "hand/anatomy.h"
#include "hand/hand_bodies.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int angle_count = 4 * finger_count;
constexpr int unknown_count = 6 + angle_count;
constexpr int most_iterations = 30;
constexpr double step_of_derivative = 1e-6;  // rad, m
constexpr double converged = 1e-6;           // rad, m, of the step

using Unknowns = Eigen::Matrix<double, unknown_count, 1>;  // turn and shift of the wrist, angles
using Residual = Eigen::Matrix<double, 3 * joint_count, 1>;

const std::array<const char*, finger_count> finger_names = {"thumb", "index", "middle", "ring", "little"};
const std::array<const char*, 3> thumb_joints = {"cmc", "mp", "ip"};
const std::array<const char*, 3> finger_joints = {"mcp", "pip", "dip"};

std::string prefix(Side side) {
  return side == Side::left ? "hand_left_" : "hand_right_";
}

// Angle k of a finger: abduction, then the flexions.
double& angle(HandPose& pose, int k) {
  FingerAngles& finger = pose.fingers[k / 4];
  return k % 4 == 0 ? finger.abduction : finger.flexion[k % 4 - 1];
}
const Eigen::Vector2d& limit(int k) {
  const FingerLimits& finger = finger_limits[k / 4];
  return k % 4 == 0 ? finger.abduction : finger.flexion[k % 4 - 1];
}
std::string jointName(Side side, int k) {
  const int finger = k / 4;
  const auto& joints = finger == 0 ? thumb_joints : finger_joints;
  return prefix(side) + finger_names[finger] + "_" +
         (k % 4 == 0 ? std::string(joints[0]) + "_abduction" : std::string(joints[k % 4 - 1]) + "_flexion");
}

HandPose moved(const HandPose& pose, const Unknowns& by) {
  HandPose out = pose;
  const Vector3d turn = by.head<3>();
  const double size = turn.norm();
  if (size > 0.0) out.wrist.linear() = Eigen::AngleAxisd(size, turn / size) * out.wrist.linear();
  out.wrist.translation() += by.segment<3>(3);
  for (int k = 0; k < angle_count; ++k)
    angle(out, k) = std::clamp(angle(out, k) + by[6 + k], limit(k)[0], limit(k)[1]);
  return out;
}

Residual residual(const HandPose& pose, const TrackedHand& hand) {
  const TrackedHand model = forwardKinematics(pose);
  Residual r;
  for (int j = 0; j < joint_count; ++j)
    r.segment<3>(3 * j) = hand.joints[j].position - model.joints[j].position;
  return r;
}

Eigen::Matrix<double, 3 * joint_count, unknown_count> derivative(const HandPose& pose,
                                                                 const TrackedHand& hand,
                                                                 const Residual& at) {
  Eigen::Matrix<double, 3 * joint_count, unknown_count> j;
  for (int k = 0; k < unknown_count; ++k) {
    Unknowns by = Unknowns::Zero();
    by[k] = step_of_derivative;
    HandPose other = moved(pose, by);
    if (k >= 6) {  // past a bound, for the derivative alone
      other = pose;
      angle(other, k - 6) += by[k];
    }
    j.col(k) = (residual(other, hand) - at) / by[k];
  }
  return j;
}

// The wrist where the palm's joints tell it is.
Eigen::Isometry3d wristPose(const TrackedHand& hand, double scale) {
  HandPose zero;
  zero.side = hand.side;
  zero.scale = scale;
  const TrackedHand rest = forwardKinematics(zero);
  const BodyPose palm_pose = bodyPoses(hand, rest)[palm_body];
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = palm_pose.rotation.toRotationMatrix();
  pose.translation() = palm_pose.position - palm_pose.rotation * bodyCentres(rest)[palm_body];
  return pose;
}

std::string numbers(const Vector3d& v) {
  std::ostringstream text;
  text.precision(9);
  text << v.x() << " " << v.y() << " " << v.z();
  return text.str();
}

// Roll, pitch, yaw with R = Rz(yaw) Ry(pitch) Rx(roll).
Vector3d rollPitchYaw(const Quaterniond& q) {
  const Eigen::Matrix3d r = q.toRotationMatrix();
  return {std::atan2(r(2, 1), r(2, 2)), std::asin(std::clamp(-r(2, 0), -1.0, 1.0)),
          std::atan2(r(1, 0), r(0, 0))};
}

// A bone along -Z of its link, as a cylinder between two balls.
void writeBone(std::ostream& out, const std::string& name, double length, double radius, double end_radius) {
  const double r = 0.5 * (radius + end_radius);
  out << "  <link name=\"" << name << "\">\n";
  const auto visual = [&](double z, const std::string& shape) {
    out << "    <visual><origin xyz=\"0 0 " << z << "\"/><geometry>" << shape
        << "</geometry><material name=\"bone\"/></visual>\n";
  };
  std::ostringstream cylinder, ball, end;
  cylinder << "<cylinder radius=\"" << 0.5 * r << "\" length=\"" << length << "\"/>";
  ball << "<sphere radius=\"" << 0.6 * radius << "\"/>";
  end << "<sphere radius=\"" << 0.6 * end_radius << "\"/>";
  visual(-0.5 * length, cylinder.str());
  visual(0.0, ball.str());
  visual(-length, end.str());
  out << "  </link>\n";
}

}  // namespace

std::vector<std::string> jointNames(Side side) {
  std::vector<std::string> names;
  for (int k = 0; k < angle_count; ++k) names.push_back(jointName(side, k));
  return names;
}

std::vector<double> jointAngles(const HandPose& pose) {
  HandPose copy = pose;
  std::vector<double> angles;
  for (int k = 0; k < angle_count; ++k) angles.push_back(angle(copy, k));
  return angles;
}

std::string handUrdf(Side side, double scale) {
  if (!(scale >= 0.4 && scale <= 2.0))
    throw std::invalid_argument("hand's scale " + std::to_string(scale) + ", expected 0.4 to 2");
  HandPose zero;
  zero.side = side;
  zero.scale = scale;
  const TrackedHand hand = forwardKinematics(zero);  // its frame is the wrist's
  const double mirror = side == Side::left ? -1.0 : 1.0;
  const std::string root = prefix(side) + "wrist";
  std::ostringstream out;
  out << "<?xml version=\"1.0\"?>\n<robot name=\"" << (side == Side::left ? "hand_left" : "hand_right")
      << "\">\n  <material name=\"bone\"><color rgba=\"0.93 0.90 0.82 1\"/></material>\n  <link name=\""
      << root << "\"/>\n";
  for (int finger = 0; finger < finger_count; ++finger) {
    const FingerJoints& joints = fingers[finger];
    const int first = finger == 0 ? 0 : 1;
    for (int i = 0; i < 4; ++i) {
      const int k = 4 * finger + i;
      const std::string name = jointName(side, k), link = name + "_link";
      const std::string parent = i == 0 ? root : jointName(side, k - 1) + "_link";
      Vector3d shift = Vector3d::Zero(), turn = Vector3d::Zero();
      if (i == 0) {
        shift = hand.joints[joints[first]].position;
        turn = rollPitchYaw(hand.joints[joints[first]].orientation);
      } else if (i > 1) {
        shift.z() = -joint_anatomy[joints[first + i - 1]].bone_length * scale;
      }
      if (i == 0) {
        out << "  <link name=\"" << link << "\"/>\n";
      } else {
        const JointAnatomy& next = joint_anatomy[joints[first + i]];
        writeBone(out, link, next.bone_length * scale, joint_anatomy[joints[first + i - 1]].radius * scale,
                  next.radius * scale);
      }
      out << "  <joint name=\"" << name << "\" type=\"revolute\">\n    <parent link=\"" << parent
          << "\"/><child link=\"" << link << "\"/>\n    <origin xyz=\"" << numbers(shift) << "\" rpy=\""
          << numbers(turn) << "\"/>\n    <axis xyz=\""
          << numbers(i == 0 ? Vector3d(0.0, mirror, 0.0) : Vector3d(-1.0, 0.0, 0.0))
          << "\"/>\n    <limit lower=\"" << limit(k)[0] << "\" upper=\"" << limit(k)[1]
          << "\" effort=\"10\" velocity=\"20\"/>\n  </joint>\n";
    }
  }
  out << "</robot>\n";
  return out.str();
}

SkeletonFit fitSkeleton(const TrackedHand& hand, const HandPose* start) {
  HandPose pose;
  if (start) pose = *start;
  pose.side = hand.side;
  pose.scale = std::clamp(personScale(hand), 0.4, 2.0);
  pose.wrist = wristPose(hand, pose.scale);
  pose = moved(pose, Unknowns::Zero());  // into the bounds
  Residual r = residual(pose, hand);
  double damping = 1e-3;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const auto j = derivative(pose, hand, r);
    Eigen::Matrix<double, unknown_count, unknown_count> normal = j.transpose() * j;
    Unknowns gradient = j.transpose() * r;
    // An angle at its bound that would go past it stays there.
    for (int k = 0; k < angle_count; ++k) {
      const double a = angle(pose, k);
      const bool held =
          (a <= limit(k)[0] && gradient[6 + k] > 0.0) || (a >= limit(k)[1] && gradient[6 + k] < 0.0);
      if (!held) continue;
      normal.row(6 + k).setZero();
      normal.col(6 + k).setZero();
      normal(6 + k, 6 + k) = 1.0;
      gradient[6 + k] = 0.0;
    }
    Eigen::Matrix<double, unknown_count, unknown_count> damped = normal;
    for (int k = 0; k < unknown_count; ++k) damped(k, k) += damping * (normal(k, k) + 1e-6);
    const Unknowns step = -damped.ldlt().solve(gradient);
    const HandPose next = moved(pose, step);
    const Residual next_r = residual(next, hand);
    if (next_r.squaredNorm() < r.squaredNorm()) {
      pose = next;
      r = next_r;
      damping = std::max(0.3 * damping, 1e-9);
      if (step.cwiseAbs().maxCoeff() < converged) break;
    } else {
      damping *= 10.0;
      if (damping > 1e6) break;
    }
  }
  SkeletonFit fit{pose, 0.0};
  for (int k = 0; k < joint_count; ++k) fit.error += r.segment<3>(3 * k).norm() / joint_count;
  return fit;
}

}  // namespace tactile_clay::hand
