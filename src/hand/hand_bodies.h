#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "hand/anatomy.h"
#include "hand/hand_shape.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// The hand's rigid parts: the palm, and three moving bones of each finger (of the thumb its metacarpal and
/// two phalanges), finger by finger from the root.
inline constexpr int body_count = 1 + 3 * finger_count;
inline constexpr int palm_body = 0;

/// A rigid part and the joint that connects it to its parent.
struct BodyAnatomy {
  int bone;    // in `bones`; for the palm the middle finger's metacarpal
  int parent;  // body; -1 for the palm
  Joint from, to;
};
extern const std::array<BodyAnatomy, body_count> body_anatomy;

/// The body that a bone of `bones` belongs to.
int bodyOfBone(int bone);

/// The first body of a finger, at its root; and the finger of a body other than the palm.
constexpr int firstBodyOf(int finger) {
  return 1 + 3 * finger;
}
constexpr int fingerOf(int moving_body) {
  return (moving_body - 1) / 3;
}

/// Position of the body's centre, and its rotation from the rest pose.
struct BodyPose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // m
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
};
using BodyPoses = std::array<BodyPose, body_count>;

/// Centres of the bodies of a hand, m: the middle of each bone; for the palm the mean of its joints.
std::array<Eigen::Vector3d, body_count> bodyCentres(const TrackedHand& hand);

/// Poses of a tracked hand's bodies relative to those of `rest` (of any size). The pose of the palm is the
/// best fit (Umeyama 1991) of its joints, so it does not depend on how a tracker turns the palm's frame. A
/// body between missing joints is turned like the palm, and its position has no meaning.
BodyPoses bodyPoses(const TrackedHand& hand, const TrackedHand& rest);
BodyPose palmPose(const TrackedHand& hand, const TrackedHand& rest);  // the palm alone
/// Whether a palm moved farther than a palm can move from one tracker sample to the next: 0.5 m or 2 rad.
bool palmLeaps(const BodyPose& last, const BodyPose& now);

/// Stiffness of the couplings that pull bodies to the tracked pose; damping is critical. Beyond `reach` they
/// pull no harder, as muscles do. So hard clay can stop the virtual hand, however deep the tracked one is in
/// it.
struct Couplings {
  double palm = 2500.0;   // N/m
  double finger = 500.0;  // N/m, of each moving bone
  double reach = 0.01;    // m; for rotations at the body's radius of gyration
};

/// Rigid bodies on critically damped springs to a moving target pose, held together by ball joints.
///
/// A spring acts as if at the body's radius of gyration g, so that turning and moving have one time constant.
/// It is integrated implicitly: a step minimises (m + h c + h^2 k)/2 |x - x_predicted|^2. A body
/// answers to its flesh and to its joints with the mass m + h c + h^2 k. Any stiffness is stable.
class HandBodies {
 public:
  /// @param mass kg, of each body with its flesh
  /// @param gyration m, radius of gyration of each body
  HandBodies(const Couplings& couplings, const std::array<double, body_count>& mass,
             const std::array<double, body_count>& gyration);

  /// Puts the bodies at rest at a pose.
  void place(const BodyPoses& poses);
  /// Sets the places of the joints in bodies and parents, from a hand whose bodies are at `poses`.
  void joints(const TrackedHand& hand, const BodyPoses& poses);

  /// First half of a step of h s: moves the bodies freely toward the target, which itself moves from
  /// `target_before` to `target`.
  /// @param flesh N/m, stiffness with which flesh carries each body along; h times it adds to the damping.
  /// This slows the way back to the target, but not a steady motion with it, and changes no force at rest
  void predict(const BodyPoses& target, const BodyPoses& target_before, double h,
               const std::array<double, body_count>& flesh);
  /// Moves body b by an impulse times h (kg m) and its moment about the centre (kg m^2).
  void push(int b, const Eigen::Vector3d& impulse, const Eigen::Vector3d& moment);
  /// Closes the joints.
  void closeJoints();
  /// Second half of a step: computes the velocities.
  void finish(double h);

  const BodyPoses& poses() const { return pose_; }
  double mass(int b) const { return effective_mass_[b]; }  // kg, in the step since `predict`
  double gyration(int b) const { return gyration_[b]; }    // m
  double kineticEnergy() const;                            // J
  double couplingEnergy(const BodyPoses& target) const;    // J

 private:
  double reach_;  // m
  std::array<double, body_count> mass_, gyration_, stiffness_, effective_mass_;
  BodyPoses pose_, before_;
  std::array<Eigen::Vector3d, body_count> velocity_, spin_;      // m/s, rad/s
  std::array<Eigen::Vector3d, body_count> in_body_, in_parent_;  // m, joints in body and parent
};

}  // namespace tactile_clay::hand
