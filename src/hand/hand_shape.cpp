#include "hand/hand_shape.h"

#include <algorithm>
#include <limits>

namespace tactile_clay::hand {

const std::array<Bone, chain_bone_count + 5> bones = {{
    {thumb_metacarpal, thumb_proximal, thumb_metacarpal, thumb_metacarpal},
    {thumb_proximal, thumb_distal, thumb_proximal, thumb_proximal},
    {thumb_distal, thumb_tip, thumb_distal, thumb_distal},
    {index_metacarpal, index_proximal, index_metacarpal, index_metacarpal},
    {index_proximal, index_intermediate, index_proximal, index_proximal},
    {index_intermediate, index_distal, index_intermediate, index_intermediate},
    {index_distal, index_tip, index_distal, index_distal},
    {middle_metacarpal, middle_proximal, middle_metacarpal, middle_metacarpal},
    {middle_proximal, middle_intermediate, middle_proximal, middle_proximal},
    {middle_intermediate, middle_distal, middle_intermediate, middle_intermediate},
    {middle_distal, middle_tip, middle_distal, middle_distal},
    {ring_metacarpal, ring_proximal, ring_metacarpal, ring_metacarpal},
    {ring_proximal, ring_intermediate, ring_proximal, ring_proximal},
    {ring_intermediate, ring_distal, ring_intermediate, ring_intermediate},
    {ring_distal, ring_tip, ring_distal, ring_distal},
    {little_metacarpal, little_proximal, little_metacarpal, little_metacarpal},
    {little_proximal, little_intermediate, little_proximal, little_proximal},
    {little_intermediate, little_distal, little_intermediate, little_intermediate},
    {little_distal, little_tip, little_distal, little_distal},
    {wrist, middle_metacarpal, palm, wrist},
    {index_proximal, middle_proximal, palm, palm},
    {middle_proximal, ring_proximal, palm, palm},
    {ring_proximal, little_proximal, palm, palm},
    {palm, thumb_proximal, palm, palm},
}};

Capsule boneCapsule(const Bone& bone, const TrackedHand& hand) {
  const JointPose& from = hand.joints[bone.from];
  const JointPose& to = hand.joints[bone.to];
  return {from.position, to.position, from.radius, to.radius};
}

double handDistance(const TrackedHand& hand, const Eigen::Vector3d& point) {
  double closest = std::numeric_limits<double>::infinity();
  for (const Bone& bone : bones) closest = std::min(closest, boneCapsule(bone, hand).distance(point));
  return closest;
}

}  // namespace tactile_clay::hand
