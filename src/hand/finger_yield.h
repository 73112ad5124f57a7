#pragma once

#include <Eigen/Core>
#include <array>

#include "hand/anatomy.h"
#include "hand/hand_bodies.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// How far a finger yields to its flesh. Even if each bone is within its reach, a pose may leave the flesh no
/// room. The finger then yields until its flesh has room. It gets its reach back when it is tracked
/// elsewhere.
struct FingerYield {
  double reach = 1.0;       // share of the finger's reach that is left
  double inside_out = 0.0;  // s, for which its flesh was inside out lately
  /// Joint positions of the tracked finger in the frame of the palm, when it yielded last.
  Eigen::Matrix<double, 3, 5> joints = Eigen::Matrix<double, 3, 5>::Zero();  // m
};
using FingerYields = std::array<FingerYield, finger_count>;

/// Adds a step of h s.
/// @param inside_out fingers whose flesh was inside out in this step
void addStep(FingerYields& yields, const std::array<bool, finger_count>& inside_out, double h);

/// Lets fingers yield, or gives them reach back, for dt s.
/// @param palm pose of the tracked palm
void yield(FingerYields& yields, const TrackedHand& tracked, const BodyPose& palm, double dt);

/// The tracked hand within the reach that is left to its fingers.
TrackedHand withinReach(const TrackedHand& tracked, const FingerYields& yields);

}  // namespace tactile_clay::hand
