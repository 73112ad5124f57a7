#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hand/hand_shape.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// A skin sample bound to its bone: it lies at centre(u) + radius(u) n. Near a knuckle n is blended with what
/// the neighbouring bone makes of it (linear blend skinning), so that a bent finger has no bare knuckle.
struct BoundSample {
  std::uint8_t bone;
  std::uint8_t neighbour;               // the bone itself where nothing is blended
  float neighbour_weight;               // 0 to 0.5
  float u;                              // 0 at the bone's start, 1 at its end
  Eigen::Vector3f normal_in_bone;       // unit
  Eigen::Vector3f normal_in_neighbour;  // unit
  float area;                           // m^2
  float pad_distance;                   // m
};

enum class SkinKind {
  kinematic,  // of bare bones: also what they cover of each other at rest
  soft        // of flesh, whole between thumb and palm, whose finger pads flatten: they have finer samples
};

/// Samples of one hand's skin in bone coordinates.
struct SkinTemplate {
  Side side = Side::right;
  double scale = 1.0;  // of the person that it was made for
  /// First those of the skin at rest, then those of what thumb and fingers cover there and bare in
  /// other poses.
  std::vector<BoundSample> samples;
  std::size_t bare_at_rest = 0;
  std::array<Eigen::Vector3d, bones.size()> rest_direction;  // of each bone, in its frame joint
};

/// Rotation from bone coordinates: the frame joint's orientation, turned the shortest way so that the bone's
/// rest direction points from its first to its second joint.
Eigen::Matrix3d boneRotation(const Bone& bone, const Eigen::Vector3d& rest_direction,
                             const TrackedHand& hand);

/// The pose in which the skin is sampled: fingers half bent and spread, so that knuckles lose little skin
/// either way.
TrackedHand restHand(Side side, double scale);

/// Samples the union of the hand's capsules: a maximal Poisson-disk set (no two samples on one side of the
/// skin closer than 0.8 spacings, none missing where one would fit), in the mean one sample a spacing
/// squared. A sample's area is the part of the skin that is closest to it. The same for what thumb and
/// fingers cover and bare at the ends of their range, beside the samples that are there. A left hand is the
/// mirror image of a right one. The finger pads of a soft hand, palmar side and tip of the last phalanges,
/// have samples 0.4 spacings apart, so that the area on which they touch is told in small steps.
/// @param spacing m, 1 to 20 mm
/// @throws std::invalid_argument
SkinTemplate makeSkinTemplate(Side side, double scale, double spacing, SkinKind kind = SkinKind::kinematic);

/// The same skin on the hand of the other side.
SkinTemplate mirroredTemplate(SkinTemplate skin);

}  // namespace tactile_clay::hand
