#pragma once

#include <Eigen/Core>
#include <array>

#include "hand/anatomy.h"
#include "hand/hand_bodies.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// How far a finger yields to its flesh. Within reach of each bone, a pose may still be one that leaves flesh
/// no room. The finger then yields until its flesh has some, and gets its reach back when it is tracked
/// elsewhere.
struct FingerYield {
  double reach = 1.0;       // share of it that is left
  double inside_out = 0.0;  // s for which flesh has been, lately
  /// The tracked finger in the palm, joint by joint, when its flesh was inside out last.
  Eigen::Matrix<double, 3, 5> joints = Eigen::Matrix<double, 3, 5>::Zero();  // m
};
using FingerYields = std::array<FingerYield, finger_count>;

/// Tells the fingers for which flesh has been inside out in a step of h s.
void addStep(FingerYields& yields, const std::array<bool, finger_count>& inside_out, double h);

/// Lets fingers yield, or gives them reach back, for dt s.
/// @param palm pose of the tracked palm
void yield(FingerYields& yields, const TrackedHand& tracked, const BodyPose& palm, double dt);

/// The tracked hand within the reach that its fingers are left.
TrackedHand withinReach(const TrackedHand& tracked, const FingerYields& yields);

}  // namespace tactile_clay::hand
