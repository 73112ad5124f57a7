#pragma once

#include <Eigen/Geometry>
#include <array>

#include "hand/capsule.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

/// One tapered capsule of the parametric hand, with the radii of its two joints.
struct Bone {
  Joint from, to;
  Joint frame;   // the joint whose orientation turns the bone
  Joint region;  // region of its skin
};

inline constexpr int chain_bone_count = 19;

/// Metacarpals and phalanges, finger by finger from the root; then the wrist, the webs between the knuckles
/// and the thumb's web, which close the palm.
extern const std::array<Bone, chain_bone_count + 5> bones;

/// Whether `next` begins where `bone` ends, in one finger.
inline bool follows(int bone, int next) {
  return bone < chain_bone_count && next < chain_bone_count && bones[next].from == bones[bone].to;
}

Capsule boneCapsule(const Bone& bone, const TrackedHand& hand);

/// Signed distance to the surface of the whole hand (the union of its capsules), m, negative inside; exact
/// outside.
double handDistance(const TrackedHand& hand, const Eigen::Vector3d& point);

}  // namespace tactile_clay::hand
