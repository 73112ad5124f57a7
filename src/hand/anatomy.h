#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>

#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

constexpr double degree = M_PI / 180.0;  // rad

/// A joint of the reference hand (scale 1). Lengths: Buryanov & Kotiuk 2010, "Proportions of hand segments".
struct JointAnatomy {
  const char* name;    // as in OpenXR, lower case
  Joint parent;        // the wrist for the palm and the metacarpals; the wrist is its own parent
  double bone_length;  // m from the parent; 0 if the two are not the ends of one bone
  double radius;       // m to the skin
};

extern const std::array<JointAnatomy, joint_count> joint_anatomy;

inline constexpr int finger_count = 5;  // thumb, index, middle, ring, little

/// Joints of a finger from the metacarpal to the tip: four for the thumb, five for the others.
struct FingerJoints {
  Joint first;
  int count;
  Joint operator[](int i) const { return static_cast<Joint>(first + i); }
  Joint tip() const { return static_cast<Joint>(first + count - 1); }
};
inline constexpr std::array<FingerJoints, finger_count> fingers = {{{thumb_metacarpal, 4},
                                                                    {index_metacarpal, 5},
                                                                    {middle_metacarpal, 5},
                                                                    {ring_metacarpal, 5},
                                                                    {little_metacarpal, 5}}};

/// Minimum number of fingers of a hand, and how many of its fingers are there as far as the tip.
inline constexpr int min_fingers = 3;
int fingersLeft(const TrackedHand& hand);

/// The metacarpals do not move in the palm, so the palm is one rigid piece. Positions of a finger's first two
/// joints and its flexion axis (+X), in the palm's frame of a right hand, scale 1. The thumb's first
/// two joints bend: its `base` stays in place, its `knuckle` moves and is given at zero angles.
struct PalmAnatomy {
  Eigen::Vector3d base;          // m, metacarpal joint
  Eigen::Vector3d knuckle;       // m, proximal joint
  Eigen::Vector3d flexion_axis;  // unit
};
extern const std::array<PalmAnatomy, finger_count> palm_anatomy;
extern const Eigen::Vector3d wrist_in_palm;  // m

/// Joints that do not move in the palm.
inline constexpr std::array<Joint, 11> palm_joints = {palm,
                                                      wrist,
                                                      thumb_metacarpal,
                                                      index_metacarpal,
                                                      index_proximal,
                                                      middle_metacarpal,
                                                      middle_proximal,
                                                      ring_metacarpal,
                                                      ring_proximal,
                                                      little_metacarpal,
                                                      little_proximal};

/// Position of one of these joints in the palm's frame of a right hand, scale 1, m.
Eigen::Vector3d placeInPalm(Joint joint);

/// Ranges of motion, rad. Flexion: MCP, PIP, DIP; of the thumb CMC, MP, IP. Abduction is positive toward the
/// thumb.
struct FingerLimits {
  std::array<Eigen::Vector2d, 3> flexion;
  Eigen::Vector2d abduction;
};
extern const std::array<FingerLimits, finger_count> finger_limits;

/// Size of a person relative to the reference hand: the median of (measured length / reference length) over
/// all bones whose two ends are known. The median, because some trackers use other proportions in single
/// bones. 0 if no bone is known.
double personScale(const std::array<std::optional<Eigen::Vector3d>, joint_count>& positions);
double personScale(const TrackedHand& hand);  // missing joints are ignored
/// Range of sizes in which a hand is accepted and simulated.
inline constexpr double smallest_hand = 0.4, largest_hand = 2.0;
/// The size of a person, clamped to `smallest_hand` ... `largest_hand`.
double handScale(const TrackedHand& hand);

}  // namespace tactile_clay::hand
