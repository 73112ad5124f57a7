#pragma once

#include <string>
#include <vector>

#include "hand/hand_pose.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// URDF of an anatomical hand: wrist, and 20 revolute joints in five fingers (of each finger abduction and
/// flexion of the first joint, flexion of the next two) with the ranges of `finger_limits`, bones of
/// `joint_anatomy` times `scale`. Its root link is `hand_left_wrist` or `hand_right_wrist`; joint angles are
/// those of HandPose. \throws std::invalid_argument if scale is not within 0.4 to 2
std::string handUrdf(Side side, double scale);

/// Names of the joints of `handUrdf`, and their angles, rad, in a pose; finger by finger.
std::vector<std::string> jointNames(Side side);
std::vector<double> jointAngles(const HandPose& pose);

struct SkeletonFit {
  HandPose pose;       // within finger_limits
  double error = 0.0;  // m, mean distance of the joints from the tracked ones
};

/// Inverse kinematics: the pose whose joints are nearest to the tracked ones (least squares over all 26), by
/// Levenberg-Marquardt with the ranges of motion as bounds.
/// \param start where to begin, such as the fit before; its side and scale are not used
SkeletonFit fitSkeleton(const TrackedHand& hand, const HandPose* start = nullptr);

}  // namespace tactile_clay::hand
