#include "hand/anatomy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace tactile_clay::hand {
namespace {

constexpr double mm = 1e-3;

PalmAnatomy palmAnatomy(const Eigen::Vector3d& base, const Eigen::Vector3d& knuckle,
                        const Eigen::Vector3d& axis, double bone_length) {
  // The positions are rounded measurements. The table gives the length; the axis is made square to the bone.
  const Eigen::Vector3d direction = (knuckle - base).normalized();
  return {knuckle * mm - direction * bone_length, knuckle * mm,
          (axis - axis.dot(direction) * direction).normalized()};
}

/// Minimum and maximum angles in degrees.
FingerLimits limits(const Eigen::Vector2d& mcp, const Eigen::Vector2d& pip, const Eigen::Vector2d& dip,
                    const Eigen::Vector2d& abduction) {
  return {{mcp * degree, pip * degree, dip * degree}, abduction * degree};
}

}  // namespace

// The radius of the palm is the distance of its joint to the palmar skin.
const std::array<JointAnatomy, joint_count> joint_anatomy = {{
    {"palm", wrist, 0.0, 8.0 * mm},
    {"wrist", wrist, 0.0, 21.5 * mm},
    {"thumb_metacarpal", wrist, 0.0, 19.4 * mm},
    {"thumb_proximal", thumb_metacarpal, 46.22 * mm, 12.3 * mm},
    {"thumb_distal", thumb_proximal, 31.57 * mm, 9.8 * mm},
    {"thumb_tip", thumb_distal, 21.67 * mm, 8.8 * mm},
    {"index_metacarpal", wrist, 0.0, 21.2 * mm},
    {"index_proximal", index_metacarpal, 68.12 * mm, 10.3 * mm},
    {"index_intermediate", index_proximal, 39.78 * mm, 8.5 * mm},
    {"index_distal", index_intermediate, 22.38 * mm, 7.6 * mm},
    {"index_tip", index_distal, 15.82 * mm, 6.6 * mm},
    {"middle_metacarpal", wrist, 0.0, 21.2 * mm},
    {"middle_proximal", middle_metacarpal, 64.60 * mm, 11.2 * mm},
    {"middle_intermediate", middle_proximal, 44.63 * mm, 8.0 * mm},
    {"middle_distal", middle_intermediate, 26.33 * mm, 7.6 * mm},
    {"middle_tip", middle_distal, 17.40 * mm, 6.6 * mm},
    {"ring_metacarpal", wrist, 0.0, 19.1 * mm},
    {"ring_proximal", ring_metacarpal, 58.00 * mm, 9.9 * mm},
    {"ring_intermediate", ring_proximal, 41.37 * mm, 7.6 * mm},
    {"ring_distal", ring_intermediate, 25.65 * mm, 7.2 * mm},
    {"ring_tip", ring_distal, 17.30 * mm, 6.2 * mm},
    {"little_metacarpal", wrist, 0.0, 18.1 * mm},
    {"little_proximal", little_metacarpal, 53.69 * mm, 8.5 * mm},
    {"little_intermediate", little_proximal, 32.74 * mm, 6.8 * mm},
    {"little_distal", little_intermediate, 18.11 * mm, 6.4 * mm},
    {"little_tip", little_distal, 15.96 * mm, 5.4 * mm},
}};

// Means over the Leap recordings that have carpPosition and bases; constant there to 0.01 mm. The thumb's
// metacarpal at rest points along (-0.44, 0, -0.90).
const std::array<PalmAnatomy, finger_count> palm_anatomy = {{
    palmAnatomy({-19.34, -6.00, 53.17}, {-39.64, -6.00, 11.65}, {0.40, 0.89, -0.20}, 46.22 * mm),
    palmAnatomy({-11.87, 12.10, 43.26}, {-23.18, 2.00, -23.15}, {0.99, 0.00, -0.17}, 68.12 * mm),
    palmAnatomy({-0.88, 13.58, 40.60}, {-2.79, 4.00, -23.25}, {0.99, -0.15, -0.01}, 64.60 * mm),
    palmAnatomy({10.41, 12.60, 39.65}, {17.45, 4.00, -17.28}, {0.97, -0.20, 0.15}, 58.00 * mm),
    palmAnatomy({21.41, 5.68, 41.81}, {35.34, 0.00, -9.73}, {0.90, -0.34, 0.28}, 53.69 * mm),
}};

const Eigen::Vector3d wrist_in_palm{7.06 * mm, 4.00 * mm, 50.00 * mm};

const std::array<FingerLimits, finger_count> finger_limits = {{
    limits({-5, 35}, {-30, 30}, {0, 80}, {-20, 20}),
    limits({-5, 100}, {-5, 100}, {-5, 90}, {-10, 20}),
    limits({-5, 100}, {-5, 100}, {-5, 90}, {-10, 10}),
    limits({-5, 100}, {-5, 100}, {-5, 90}, {-10, 10}),
    limits({-5, 100}, {-5, 100}, {-5, 90}, {-30, 10}),
}};

double personScale(const std::array<std::optional<Eigen::Vector3d>, joint_count>& positions) {
  std::vector<double> ratios;
  for (int joint = 0; joint < joint_count; ++joint) {
    const JointAnatomy& anatomy = joint_anatomy[joint];
    if (anatomy.bone_length == 0.0 || !positions[joint] || !positions[anatomy.parent]) continue;
    ratios.push_back((*positions[joint] - *positions[anatomy.parent]).norm() / anatomy.bone_length);
  }
  if (ratios.empty()) return 0.0;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return *middle;
}

double personScale(const TrackedHand& hand) {
  std::array<std::optional<Eigen::Vector3d>, joint_count> positions;
  for (int joint = 0; joint < joint_count; ++joint)
    if (!hand.missing[joint]) positions[joint] = hand.joints[joint].position;
  return personScale(positions);
}
int fingersLeft(const TrackedHand& hand) {
  return static_cast<int>(std::count_if(fingers.begin(), fingers.end(), [&](const FingerJoints& finger) {
    return !hand.missing[finger.tip()];
  }));
}

double handScale(const TrackedHand& hand) {
  return std::clamp(personScale(hand), smallest_hand, largest_hand);
}

Eigen::Vector3d placeInPalm(Joint joint) {
  if (joint == palm) return Eigen::Vector3d::Zero();
  if (joint == wrist) return wrist_in_palm;
  const auto finger = std::find_if(fingers.rbegin(), fingers.rend(),
                                   [joint](const FingerJoints& one) { return joint >= one.first; });
  const PalmAnatomy& anatomy = palm_anatomy[fingers.rend() - finger - 1];
  return joint == finger->first ? anatomy.base : anatomy.knuckle;
}

}  // namespace tactile_clay::hand
