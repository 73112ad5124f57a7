#include "hand/posed_skin.h"

#include <algorithm>
#include <cmath>

#include "hand/anatomy.h"

namespace tactile_clay::hand {
namespace {

constexpr double rounding = 1e-6;  // m, of points in single precision

}  // namespace

PosedSkin::PosedSkin(const SkinTemplate& skin, const TrackedHand& hand)
    : growth_(std::pow(personScale(hand) / skin.scale, 2)) {
  for (std::size_t i = 0; i < bones.size(); ++i) {
    const JointPose& from = hand.joints[bones[i].from];
    const JointPose& to = hand.joints[bones[i].to];
    poses_[i] = {from.position.cast<float>(), (to.position - from.position).cast<float>(),
                 static_cast<float>(from.radius), static_cast<float>(to.radius - from.radius),
                 boneRotation(bones[i], skin.rest_direction[i], hand).cast<float>()};
    capsules_[i] = boneCapsule(bones[i], hand);
    absent_[i] = hand.missing[bones[i].from] || hand.missing[bones[i].to];
    balls_[i] = capsules_[i].ball();
    balls_[i].radius += rounding;
  }
  for (std::size_t i = 0; i < bones.size(); ++i)
    for (std::size_t k = 0; k < bones.size(); ++k)
      near_[i][k] = k != i && !absent_[k] &&
                    (balls_[k].middle - balls_[i].middle).norm() <= balls_[k].radius + balls_[i].radius;
}

Eigen::Vector3f PosedSkin::normal(const BoundSample& sample) const {
  Eigen::Vector3f normal = poses_[sample.bone].rotation * sample.normal_in_bone;
  if (sample.neighbour_weight == 0.0F || absent_[sample.neighbour]) return normal;
  const Eigen::Vector3f blended =
      (1.0F - sample.neighbour_weight) * normal +
      sample.neighbour_weight * (poses_[sample.neighbour].rotation * sample.normal_in_neighbour);
  // Only a completely folded knuckle cancels the two normals. Then the normal of the bone counts.
  const float norm = blended.norm();
  if (norm > 1e-3F) normal = blended / norm;
  return normal;
}

PosedSkin::Sample PosedSkin::operator()(const BoundSample& sample) const {
  const BonePose& bone = poses_[sample.bone];
  Sample out;
  out.normal = normal(sample);
  out.axis = bone.from + sample.u * bone.along;
  out.radius = bone.radius_from + sample.u * bone.radius_growth;
  out.surface = out.axis + out.radius * out.normal;
  return out;
}

float PosedSkin::area(const BoundSample& sample) const {
  return sample.area * static_cast<float>(growth_);
}

float PosedSkin::padDistance(const BoundSample& sample) const {
  return sample.pad_distance * static_cast<float>(std::sqrt(growth_));
}

double PosedSkin::depth(const BoundSample& sample, const Eigen::Vector3f& point) const {
  const Eigen::Vector3d x = point.cast<double>();
  const auto& near = near_[sample.bone];
  double distance = 0.0;
  for (std::size_t other = 0; other < capsules_.size(); ++other) {
    const Ball& ball = balls_[other];
    if (near[other] && (x - ball.middle).squaredNorm() <= ball.radius * ball.radius)
      distance = std::min(distance, capsules_[other].distance(x));
  }
  return -distance;
}

void append(Skin& skin, const PosedSkin& posed, const BoundSample& bound, const PosedSkin::Sample& sample,
            Side side) {
  skin.position.push_back(sample.surface);
  skin.normal.push_back(sample.normal);
  skin.velocity.push_back(Eigen::Vector3f::Zero());
  skin.area.push_back(posed.area(bound));
  skin.pad_distance.push_back(posed.padDistance(bound));
  skin.side.push_back(static_cast<std::uint8_t>(side));
  skin.region.push_back(static_cast<std::uint8_t>(bones[bound.bone].region));
}

}  // namespace tactile_clay::hand
