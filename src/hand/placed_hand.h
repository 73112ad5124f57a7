#pragma once

#include <Eigen/Geometry>
#include <functional>

#include "hand/hand_pose.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// The place between a and b where `holds`, which is true at a and false at b, ends: the nearest one to it at
/// which it is false.
template <typename Holds>
double bisect(double a, double b, const Holds& holds) {
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (a + b);
    (holds(middle) ? a : b) = middle;
  }
  return b;
}

/// Orientation of a hand with its palm down and its fingers forward (x of the world).
/// @param pitch rad, by which the fingers point down
Eigen::Isometry3d palmDown(double pitch);

/// A hand at the origin with the same flexion of all fingers, rad, its thumb beside the palm.
/// @param mcp, pip, dip flexion of the joints of a finger, from the palm on
HandPose curled(Side side, double scale, double mcp, double pip, double dip);

/// Smallest `measure` (of centre and radius, m) over the spheres that sweep the hand's capsules.
double smallest(const TrackedHand& hand,
                const std::function<double(const Eigen::Vector3d& centre, double radius)>& measure);

/// The hand turned to `orientation`, with `joint` over (x, y) of the target and its lowest skin at z of the
/// target, m.
HandPose placed(HandPose pose, const Eigen::Isometry3d& orientation, Joint joint,
                const Eigen::Vector3d& target);

/// The hand raised by z, m.
HandPose lifted(HandPose pose, double z);

}  // namespace tactile_clay::hand
