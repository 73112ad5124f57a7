#include "hand/kinematic_hand.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "hand/anatomy.h"
#include "hand/hand_sides.h"
#include "hand/posed_skin.h"

namespace tactile_clay::hand {
namespace {

constexpr double person_change = 0.1;  // relative
constexpr double scale_step = 0.05;    // sizes are rounded to it, so persons of about one size get one result

// How far a sample withdraws to its axis, 0 to 1. It is 1 from `withdrawn_below` of the radius on.
// `depth`: m, of the sample in other flesh.
float withdrawal(double depth, float radius) {
  constexpr double withdrawn_below = 0.1;
  return static_cast<float>(std::min(1.0, depth / (withdrawn_below * radius)));
}

}  // namespace

SkinTemplates::SkinTemplates(double spacing, SkinKind kind) : spacing_(spacing), kind_(kind) {
  // Made here, the skins of most adults cost nothing when their hands appear.
  constexpr double adult = 1.05;
  SkinTemplate right = makeSkinTemplate(Side::right, adult, spacing, kind);
  templates_[0] = std::make_shared<SkinTemplate>(mirroredTemplate(right));
  templates_[1] = std::make_shared<SkinTemplate>(std::move(right));
}

std::shared_ptr<const SkinTemplate> SkinTemplates::of(const TrackedHand& hand) {
  auto& skin = templates_[static_cast<int>(hand.side)];
  const double scale = handScale(hand);
  if (std::abs(scale / skin->scale - 1.0) > person_change)
    skin = std::make_shared<SkinTemplate>(
        makeSkinTemplate(hand.side, std::round(scale / scale_step) * scale_step, spacing_, kind_));
  return skin;
}

Skin KinematicHands::update(const std::vector<TrackedHand>& hands_in_world, std::chrono::nanoseconds stamp) {
  Skin skin;
  std::array<bool, 2> present{};
  for (const TrackedHand& hand : leftThenRight(hands_in_world)) {
    append(skin, hand, stamp);
    present[static_cast<int>(hand.side)] = true;
  }
  for (int side = 0; side < 2; ++side)
    if (!present[side]) tracked_[side].reset();
  return skin;
}

void KinematicHands::append(Skin& skin, const TrackedHand& hand, std::chrono::nanoseconds stamp) {
  std::optional<Tracked>& tracked = tracked_[static_cast<int>(hand.side)];
  const BodyPose palm = palmPose(hand, rest_[static_cast<int>(hand.side)]);
  const bool goes_on = tracked && !palmLeaps(tracked->palm, palm);
  if (!tracked) tracked.emplace().skin = templates_.of(hand);
  const SkinTemplate& skin_template = *tracked->skin;

  const double dt = goes_on ? std::chrono::duration<double>(stamp - tracked->stamp).count() : 0.0;
  const float per_second = dt > 0.0 ? static_cast<float>(1.0 / dt) : 0.0F;

  const PosedSkin posed(skin_template, hand);
  tracked->surface.resize(skin_template.samples.size(), Eigen::Vector3f::Zero());
  tracked->axis.resize(skin_template.samples.size(), Eigen::Vector3f::Zero());
  for (std::size_t i = 0; i < skin_template.samples.size(); ++i) {
    const BoundSample& bound = skin_template.samples[i];
    if (posed.absent(bound)) continue;
    const PosedSkin::Sample sample = posed(bound);
    const double depth = posed.depth(bound, sample.surface);
    const float deep = i < skin_template.bare_at_rest ? 0.0F : withdrawal(depth, sample.radius);
    // The velocity is the bone's, not that of withdrawing: the clay meets skin that was there before.
    const Eigen::Vector3f step =
        (1.0F - deep) * (sample.surface - tracked->surface[i]) + deep * (sample.axis - tracked->axis[i]);
    hand::append(skin, posed, bound, sample, hand.side);
    skin.position.back() = (1.0F - deep) * sample.surface + deep * sample.axis;
    // A sample within the hand touches nothing that could be felt.
    if (depth > bare_within || deep * sample.radius > bare_within) skin.area.back() = 0.0F;
    const bool anew =
        tracked->bare[bound.bone] || tracked->bare[bound.neighbour] != posed.absentBones()[bound.neighbour];
    skin.velocity.back() = anew ? Eigen::Vector3f::Zero() : Eigen::Vector3f(step * per_second);
    tracked->surface[i] = sample.surface;
    tracked->axis[i] = sample.axis;
  }
  tracked->bare = posed.absentBones();
  tracked->palm = palm;
  tracked->stamp = stamp;
}

}  // namespace tactile_clay::hand
