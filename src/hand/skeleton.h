#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "hand/anatomy.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// Joints of the skeleton finger by finger from the root: of each finger abduction and flexion of the MCP,
/// flexion of PIP and DIP; of the thumb abduction and flexion of CMC and MP, flexion of the IP.
inline constexpr int skeleton_joint_count = 21;
using SkeletonAngles = std::array<double, skeleton_joint_count>;  // rad

/// What of a person's hand stays the same as it moves. Positions in m in the frame of the wrist (-Z along the
/// palm, +Y dorsal), those of a left hand mirrored as if it were a right one.
struct Skeleton {
  Side side = Side::right;
  double scale = 1.0;  // of the person, for the radii
  Eigen::Vector3d palm;
  struct Finger {
    Eigen::Vector3d metacarpal;    // of the thumb the same as its root
    Eigen::Vector3d root;          // where the first moving bone begins: the knuckle, of the thumb the CMC
    Eigen::Quaterniond straight;   // frame of the first moving bone at zero angles
    std::array<double, 3> bone{};  // m, lengths of the moving bones
  };
  std::array<Finger, finger_count> fingers;
};

/// A hand by the pose of its wrist and its angles.
struct SkeletonPose {
  Eigen::Isometry3d wrist = Eigen::Isometry3d::Identity();
  SkeletonAngles angles{};
};

/// Minimum and maximum angle of a joint, rad; `finger_limits`, and 10 degrees to each side for the abduction
/// of the thumb's MP, which has no entry there.
Eigen::Vector2d skeletonLimits(int joint);

/// Name of a joint of a side, such as `hand_left_index_mcp_flexion`.
std::string skeletonJointName(Side side, int joint);

/// Measures a person: means of the positions in the palm, medians of the bone lengths, and as zero abduction
/// the mean direction of middle and ring finger, because trackers differ in what they call the palm's
/// direction.
/// @param samples of one hand of one side, one or more
/// @throws std::invalid_argument if there is none, joints of one are missing, or their bones are not 0.4 to 2
/// times those of `joint_anatomy`
Skeleton measureSkeleton(const std::vector<TrackedHand>& samples);

/// Forward kinematics: positions of the 26 joints, m, in the frame that the wrist is given in.
std::array<Eigen::Vector3d, joint_count> jointPositions(const Skeleton& skeleton, const SkeletonPose& pose);

struct SkeletonFit {
  SkeletonPose pose;                        // within the limits
  std::array<double, joint_count> error{};  // m, of each joint from the tracked one
};

/// Inverse kinematics. The wrist is the best fit of the palm's joints (Umeyama 1991); the angles of each
/// finger are those within the limits with the least squares of the distances of its joints
/// (Levenberg-Marquardt). A finger with missing joints keeps its angles, and missing joints have no error.
/// @param start where to begin, such as the pose before
SkeletonFit fitSkeleton(const Skeleton& skeleton, const TrackedHand& hand,
                        const SkeletonPose* start = nullptr);

/// URDF: root link `hand_left_wrist` or `hand_right_wrist`, 21 revolute joints with their limits, and a fixed
/// one to each fingertip. Joint angles are those of SkeletonPose.
std::string skeletonUrdf(const Skeleton& skeleton);

}  // namespace tactile_clay::hand
