#include "hand/skeleton.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "hand/hand_pose.h"
#include "hand/rigid_motion.h"
#include "hand/skeleton_joints.h"

namespace tactile_clay::hand {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Positions = std::array<Vector3d, joint_count>;

constexpr int max_angles = 5;     // of a finger
constexpr int max_steps = 30;     // of Levenberg-Marquardt
constexpr double settled = 1e-6;  // rad, of a step

// The thumb's frame at zero angles, in that of its metacarpal in palm_anatomy, as a rotation vector. With it
// the ranges of motion contain the thumb's tracked directions best. Fitted to six recordings of both sides.
// Leaving out any one changes the mean error of its thumb by less than 1.2 mm.
const Vector3d thumb_straight(0.24, 0.23, -0.48);  // rad

// Positions as of a right hand; a left hand is mirrored.
Positions rightHanded(const TrackedHand& hand) {
  Positions positions;
  for (int j = 0; j < joint_count; ++j)
    positions[j] = hand.side == Side::left ? mirrored(hand.joints[j].position) : hand.joints[j].position;
  return positions;
}
Isometry3d mirrored(const Isometry3d& pose) {
  return Eigen::Translation3d(hand::mirrored(Vector3d(pose.translation()))) *
         hand::mirrored(Quaterniond(pose.rotation()));
}

// The rigid motion that brings the palm's joints of `from`, as far as they are seen, nearest to those of
// `to`.
Isometry3d palmMotion(const Positions& from, const Positions& to, const std::bitset<joint_count>& missing) {
  Eigen::Matrix3Xd a(3, palm_joints.size()), b = a;
  Eigen::Index seen = 0;
  for (const Joint joint : palm_joints) {
    if (missing[joint]) continue;
    a.col(seen) = from[joint];
    b.col(seen++) = to[joint];
  }
  return rigidMotion(a.leftCols(seen), b.leftCols(seen));
}

// A finger in the wrist's frame of a right hand, with the axis of every angle.
struct Chain {
  std::array<Vector3d, bone_count + 1> joint;  // m
  std::array<Vector3d, max_angles> axis, origin;
};

Chain chain(const Skeleton::Finger& finger, int number, const double* angles) {
  Chain out;
  Quaterniond frame = finger.straight;
  out.joint[0] = finger.root;
  int k = 0;
  for (int bone = 0; bone < bone_count; ++bone) {
    const auto turn = [&](const Vector3d& axis) {
      out.axis[k] = frame * axis;
      out.origin[k] = out.joint[bone];
      frame = frame * AngleAxisd(angles[k++], axis);
    };
    if (hasAbduction(number, bone)) turn(Vector3d::UnitY());  // toward the thumb
    turn(-Vector3d::UnitX());                                 // toward the palm
    out.joint[bone + 1] = out.joint[bone] + frame * Vector3d(0.0, 0.0, -finger.bone[bone]);
  }
  return out;
}

using Targets = std::array<Vector3d, bone_count>;  // the far ends of the bones
using Residual = Eigen::Matrix<double, 3 * bone_count, 1>;

Residual residual(const Chain& chain, const Targets& targets) {
  Residual r;
  for (int i = 0; i < bone_count; ++i) r.segment<3>(3 * i) = chain.joint[i + 1] - targets[i];
  return r;
}

void fitFinger(const Skeleton::Finger& finger, int number, const Targets& targets, double* angles) {
  const int n = angleCount(number), first = firstAngle(number);
  using Unknowns = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_angles, 1>;
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_angles, max_angles>;
  for (int k = 0; k < n; ++k) {
    const Vector2d limit = skeletonLimits(first + k);
    angles[k] = std::clamp(angles[k], limit[0], limit[1]);
  }
  Chain at = chain(finger, number, angles);
  Residual r = residual(at, targets);
  double damping = 1e-3;
  for (int step = 0; step < max_steps; ++step) {
    Eigen::Matrix<double, 3 * bone_count, Eigen::Dynamic, 0, 3 * bone_count, max_angles> j(3 * bone_count, n);
    for (int k = 0; k < n; ++k)
      for (int i = 0; i < bone_count; ++i)
        j.block<3, 1>(3 * i, k) = at.axis[k].cross(at.joint[i + 1] - at.origin[k]);
    // A joint bends only the bones behind it.
    for (int k = 0; k < n; ++k)
      for (int i = 0; i < placeOf(first + k).bone; ++i) j.block<3, 1>(3 * i, k).setZero();
    Square normal = j.transpose() * j;
    Unknowns gradient = j.transpose() * r;
    // An angle at its limit that would go past it stays there.
    for (int k = 0; k < n; ++k) {
      const Vector2d limit = skeletonLimits(first + k);
      if (!((angles[k] <= limit[0] && gradient[k] > 0.0) || (angles[k] >= limit[1] && gradient[k] < 0.0)))
        continue;
      normal.row(k).setZero();
      normal.col(k).setZero();
      normal(k, k) = 1.0;
      gradient[k] = 0.0;
    }
    for (int k = 0; k < n; ++k) normal(k, k) += damping * normal(k, k) + 1e-12;
    const Unknowns by = -normal.ldlt().solve(gradient);
    std::array<double, max_angles> next{};
    double moved = 0.0;
    for (int k = 0; k < n; ++k) {
      const Vector2d limit = skeletonLimits(first + k);
      next[k] = std::clamp(angles[k] + by[k], limit[0], limit[1]);
      moved = std::max(moved, std::abs(next[k] - angles[k]));
    }
    const Chain there = chain(finger, number, next.data());
    const Residual next_r = residual(there, targets);
    if (next_r.squaredNorm() <= r.squaredNorm()) {
      std::copy_n(next.begin(), n, angles);
      at = there;
      r = next_r;
      damping = std::max(0.3 * damping, 1e-9);
      if (moved < settled) return;
    } else if ((damping *= 10.0) > 1e6) {
      return;
    }
  }
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Skeleton measureSkeleton(const std::vector<TrackedHand>& samples) {
  if (samples.empty())
    throw std::invalid_argument("a skeleton is to be measured of no sample, expected some");
  const Positions reference = rightHanded(forwardKinematics(HandPose()));
  Positions mean;
  mean.fill(Vector3d::Zero());
  Vector3d ahead = Vector3d::Zero();  // where middle and ring finger point
  std::vector<double> scales;
  std::array<std::vector<double>, finger_count * bone_count> lengths;
  for (const TrackedHand& hand : samples) {
    if (hand.missing.any())
      throw std::invalid_argument(
          "a skeleton is to be measured of a hand with missing joints, expected whole hands");
    const Positions positions = rightHanded(hand);
    const Isometry3d to_reference = palmMotion(positions, reference, {});
    for (const Joint joint : palm_joints)
      mean[joint] += to_reference * positions[joint] / static_cast<double>(samples.size());
    for (int finger = 0; finger < finger_count; ++finger)
      for (int i = 0; i < bone_count; ++i) {
        const Vector3d bone = positions[movingJoint(finger, i + 1)] - positions[movingJoint(finger, i)];
        lengths[finger * bone_count + i].push_back(bone.norm());
        if (i == 0 && (finger == 2 || finger == 3)) ahead += to_reference.linear() * bone.normalized();
      }
    scales.push_back(personScale(hand));
  }
  Skeleton skeleton;
  skeleton.side = samples.front().side;
  skeleton.scale = median(scales);
  if (!(skeleton.scale >= 0.4 && skeleton.scale <= 2.0))
    throw std::invalid_argument("bones of a hand are " + std::to_string(skeleton.scale) +
                                " times an adult's, expected 0.4 to 2 times");
  // The direction of bent fingers in the palm's plane has little meaning.
  ahead.y() = 0.0;
  const bool known = -ahead.z() > 0.4 * static_cast<double>(2 * samples.size());
  const Quaterniond turn(AngleAxisd(known ? std::atan2(ahead.x(), -ahead.z()) : 0.0, Vector3d::UnitY()));
  const auto in_palm = [&](Joint joint) -> Vector3d { return turn * (mean[joint] - mean[wrist]); };
  skeleton.palm = in_palm(palm);
  for (int f = 0; f < finger_count; ++f) {
    Skeleton::Finger& finger = skeleton.fingers[f];
    finger.metacarpal = in_palm(fingers[f][0]);
    finger.root = in_palm(movingJoint(f, 0));
    const PalmAnatomy& anatomy = palm_anatomy[f];
    finger.straight = f == 0 ? turn * boneOrientation(anatomy.knuckle - anatomy.base, anatomy.flexion_axis) *
                                   AngleAxisd(thumb_straight.norm(), thumb_straight.normalized())
                             : boneOrientation(-Vector3d::UnitZ(), turn * anatomy.flexion_axis);
    for (int i = 0; i < bone_count; ++i) finger.bone[i] = median(lengths[f * bone_count + i]);
  }
  return skeleton;
}

std::array<Vector3d, joint_count> jointPositions(const Skeleton& skeleton, const SkeletonPose& pose) {
  Positions positions;
  positions[wrist].setZero();
  positions[palm] = skeleton.palm;
  for (int f = 0; f < finger_count; ++f) {
    const Skeleton::Finger& finger = skeleton.fingers[f];
    positions[fingers[f][0]] = finger.metacarpal;
    const Chain at = chain(finger, f, pose.angles.data() + firstAngle(f));
    for (int i = 0; i <= bone_count; ++i) positions[movingJoint(f, i)] = at.joint[i];
  }
  for (Vector3d& position : positions)
    position = pose.wrist * (skeleton.side == Side::left ? mirrored(position) : position);
  return positions;
}

SkeletonFit fitSkeleton(const Skeleton& skeleton, const TrackedHand& hand, const SkeletonPose* start) {
  SkeletonFit fit;
  if (start) fit.pose = *start;
  TrackedHand seen = hand;
  seen.side = skeleton.side;
  const Positions tracked = rightHanded(seen);
  SkeletonPose zero;
  Skeleton right = skeleton;
  right.side = Side::right;
  const Isometry3d wrist_pose = palmMotion(jointPositions(right, zero), tracked, hand.missing);
  fit.pose.wrist = skeleton.side == Side::left ? mirrored(wrist_pose) : wrist_pose;
  const Isometry3d to_wrist = wrist_pose.inverse();
  for (int f = 0; f < finger_count; ++f) {
    if (hand.missing[fingers[f].tip()]) continue;
    Targets targets;
    for (int i = 0; i < bone_count; ++i) targets[i] = to_wrist * tracked[movingJoint(f, i + 1)];
    fitFinger(skeleton.fingers[f], f, targets, fit.pose.angles.data() + firstAngle(f));
  }
  const Positions found = jointPositions(skeleton, fit.pose);
  for (int j = 0; j < joint_count; ++j)
    if (!hand.missing[j]) fit.error[j] = (found[j] - hand.joints[j].position).norm();
  return fit;
}

}  // namespace tactile_clay::hand
