#include "hand/kinematic_hand.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "hand/anatomy.h"
#include "hand/hand_check.h"

namespace tactile_clay::hand {
namespace {

constexpr double person_change = 0.1;  // relative
constexpr double scale_step = 0.05;    // persons between two steps share a template, and so a result

struct BonePose {
  Eigen::Vector3f from, along;  // m
  float radius_from, radius_growth;
  Eigen::Matrix3f rotation;
};

BonePose bonePose(const Bone& bone, const Eigen::Vector3d& rest_direction, const TrackedHand& hand) {
  const JointPose& from = hand.joints[bone.from];
  const JointPose& to = hand.joints[bone.to];
  return {from.position.cast<float>(), (to.position - from.position).cast<float>(),
          static_cast<float>(from.radius), static_cast<float>(to.radius - from.radius),
          boneRotation(bone, rest_direction, hand).cast<float>()};
}

using Bones = std::bitset<bones.size()>;

Eigen::Vector3f sampleNormal(const BoundSample& sample, const std::array<BonePose, bones.size()>& poses,
                             const Bones& bare) {
  Eigen::Vector3f normal = poses[sample.bone].rotation * sample.normal_in_bone;
  if (sample.neighbour_weight == 0.0F || bare[sample.neighbour]) return normal;
  const Eigen::Vector3f blended =
      (1.0F - sample.neighbour_weight) * normal +
      sample.neighbour_weight * (poses[sample.neighbour].rotation * sample.normal_in_neighbour);
  // Only a knuckle folded right over cancels the two; then the bone itself decides.
  const float norm = blended.norm();
  if (norm > 1e-3F) normal = blended / norm;
  return normal;
}

// How far a sample of `bone` withdraws to its axis, 0 to 1: wholly where it is deeper in other flesh than
// `withdrawn_below` of its radius.
float withdrawal(int bone, const Eigen::Vector3f& surface, float radius,
                 const std::array<Capsule, bones.size()>& capsules, const Bones& bare) {
  constexpr double withdrawn_below = 0.1;
  const Eigen::Vector3d point = surface.cast<double>();
  double distance = 0.0;
  for (int other = 0; other < static_cast<int>(capsules.size()); ++other)
    if (other != bone && !bare[other] && capsules[other].mayBeWithin(0.0, point))
      distance = std::min(distance, capsules[other].distance(point));
  return static_cast<float>(std::min(1.0, -distance / (withdrawn_below * radius)));
}

}  // namespace

KinematicHands::KinematicHands(double spacing, SkinKind kind) : spacing_(spacing), kind_(kind) {
  // Made now, most adults' hands cost nothing when they appear.
  constexpr double adult = 1.05;
  SkinTemplate right = makeSkinTemplate(Side::right, adult, spacing, kind);
  templates_[0] = std::make_shared<SkinTemplate>(mirroredTemplate(right));
  templates_[1] = std::make_shared<SkinTemplate>(std::move(right));
}

std::shared_ptr<const SkinTemplate> KinematicHands::templateFor(const TrackedHand& hand) {
  auto& skin = templates_[static_cast<int>(hand.side)];
  const double scale = handScale(hand);
  if (std::abs(scale / skin->scale - 1.0) > person_change)
    skin = std::make_shared<SkinTemplate>(
        makeSkinTemplate(hand.side, std::round(scale / scale_step) * scale_step, spacing_, kind_));
  return skin;
}

const Skin& KinematicHands::update(const std::vector<TrackedHand>& hands_in_world,
                                   std::chrono::nanoseconds stamp) {
  for (const TrackedHand& hand : hands_in_world) {
    const std::string fault = faultOf(hand);
    if (!fault.empty()) throw std::invalid_argument(fault);
  }
  std::vector<TrackedHand> hands = hands_in_world;
  keepOneHandASide(hands);
  std::sort(hands.begin(), hands.end(), [](const auto& a, const auto& b) { return a.side < b.side; });
  skin_ = Skin();
  std::array<bool, 2> present{};
  for (const TrackedHand& hand : hands) {
    append(hand, stamp);
    present[static_cast<int>(hand.side)] = true;
  }
  for (int side = 0; side < 2; ++side)
    if (!present[side]) tracked_[side].reset();
  return skin_;
}

void KinematicHands::append(const TrackedHand& hand, std::chrono::nanoseconds stamp) {
  std::optional<Tracked>& tracked = tracked_[static_cast<int>(hand.side)];
  const BodyPose palm = palmPose(hand, rest_[static_cast<int>(hand.side)]);
  const bool goes_on = tracked && !palmLeaps(tracked->palm, palm);
  if (!tracked) tracked.emplace().skin = templateFor(hand);
  const SkinTemplate& skin = *tracked->skin;

  std::array<BonePose, bones.size()> poses;
  std::array<Capsule, bones.size()> capsules;
  Bones bare;
  for (std::size_t i = 0; i < bones.size(); ++i) {
    bare[i] = hand.missing[bones[i].from] || hand.missing[bones[i].to];
    poses[i] = bonePose(bones[i], skin.rest_direction[i], hand);
    capsules[i] = boneCapsule(bones[i], hand);
  }
  const double dt = goes_on ? std::chrono::duration<double>(stamp - tracked->stamp).count() : 0.0;
  const float per_second = dt > 0.0 ? static_cast<float>(1.0 / dt) : 0.0F;

  const std::size_t count = skin.samples.size();
  // Areas are the template's, resized with the person as the tracker sees it now.
  const double growth = std::pow(personScale(hand) / skin.scale, 2);
  tracked->surface.resize(count, Eigen::Vector3f::Zero());
  tracked->axis.resize(count, Eigen::Vector3f::Zero());
  for (std::size_t i = 0; i < count; ++i) {
    const BoundSample& sample = skin.samples[i];
    if (bare[sample.bone]) continue;
    const BonePose& bone = poses[sample.bone];
    const Eigen::Vector3f normal = sampleNormal(sample, poses, bare);
    const Eigen::Vector3f axis = bone.from + sample.u * bone.along;
    const float radius = bone.radius_from + sample.u * bone.radius_growth;
    const Eigen::Vector3f surface = axis + radius * normal;
    const float deep =
        i < skin.bare_at_rest ? 0.0F : withdrawal(sample.bone, surface, radius, capsules, bare);
    // As fast as the bone, not as it withdraws: clay is met by skin that was there before.
    const Eigen::Vector3f step =
        (1.0F - deep) * (surface - tracked->surface[i]) + deep * (axis - tracked->axis[i]);
    skin_.position.push_back((1.0F - deep) * surface + deep * axis);
    skin_.normal.push_back(normal);
    const bool anew = tracked->bare[sample.bone] || tracked->bare[sample.neighbour] != bare[sample.neighbour];
    skin_.velocity.push_back(anew ? Eigen::Vector3f::Zero() : Eigen::Vector3f(step * per_second));
    tracked->surface[i] = surface;
    tracked->axis[i] = axis;
    skin_.area.push_back(sample.area * static_cast<float>(growth));
    skin_.pad_distance.push_back(sample.pad_distance * static_cast<float>(std::sqrt(growth)));
    skin_.side.push_back(static_cast<std::uint8_t>(hand.side));
    skin_.region.push_back(static_cast<std::uint8_t>(bones[sample.bone].region));
  }
  tracked->bare = bare;
  tracked->palm = palm;
  tracked->stamp = stamp;
}

}  // namespace tactile_clay::hand
