#include "hand/soft_hands.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "hand/hand_sides.h"
#include "hand/posed_skin.h"
#include "values/range.h"

namespace tactile_clay::hand {
namespace {

constexpr double load_lifetime = 0.1;         // s
constexpr std::size_t remembered_skins = 16;  // skins
constexpr double seconds_a_nano = 1e-9;

const SoftHandParameters& checked(double spacing, const SoftHandParameters& parameters) {
  using values::requireIn;
  requireIn("soft hand: spacing of the skin (m)", spacing, 1e-3, 20e-3);
  requireIn("soft hand: young (Pa)", parameters.young, 1e3, 1e6);
  requireIn("soft hand: poisson", parameters.poisson, 0.0, 0.49);
  requireIn("soft hand: density (kg/m^3)", parameters.density, 100.0, 10000.0);
  requireIn("soft hand: relaxation", parameters.relaxation, 0.01, 100.0);
  requireIn("soft hand: finger_cell (m)", parameters.finger_cell, 2e-3, 10e-3);
  requireIn("soft hand: palm_cell (m)", parameters.palm_cell, 2e-3, 15e-3);
  requireIn("soft hand: step (s)", parameters.step, 1e-4, 0.02);
  requireIn("soft hand: stiffness of the palm's coupling (N/m)", parameters.couplings.palm, 1.0, 1e5);
  requireIn("soft hand: stiffness of the fingers' couplings (N/m)", parameters.couplings.finger, 1.0, 1e5);
  requireIn("soft hand: reach of the couplings (m)", parameters.couplings.reach, 1e-3, 1.0);
  return parameters;
}

// A missing finger rests beside the palm, and has no skin.
std::vector<std::uint32_t> samplesOfSeenJoints(const Skin& skin, const TrackedHand& hand) {
  std::vector<std::uint32_t> seen;
  for (std::size_t i = 0; i < skin.size(); ++i) {
    const int region = skin.region[i];  // the joint where the bone begins: it ends at the next one
    if (region < thumb_metacarpal || !hand.missing[region + 1]) seen.push_back(static_cast<std::uint32_t>(i));
  }
  return seen;
}

Skin skinOf(const SkinTemplate& skin_template, const TrackedHand& hand) {
  const PosedSkin posed(skin_template, hand);
  Skin skin;
  for (const BoundSample& bound : skin_template.samples) append(skin, posed, bound, posed(bound), hand.side);
  return skin;
}

// Places of the samples of a soft hand on the tracked hand: on its bones as they are tracked. Samples on a
// missing bone have no place, and are not felt.
void appendTracked(Skin& skin, const Skin& held, const std::vector<std::uint32_t>& shown,
                   const SkinTemplate& skin_template, const TrackedHand& tracked) {
  const PosedSkin posed(skin_template, tracked);
  for (const std::uint32_t i : shown) {
    const BoundSample& bound = skin_template.samples[i];
    const bool seen = !posed.absent(bound);
    const PosedSkin::Sample sample = posed(bound);
    const bool bare = seen && posed.depth(bound, sample.surface) <= bare_within;
    skin.tracked_position.push_back(seen ? sample.surface : held.position[i]);
    skin.tracked_normal.push_back(seen ? sample.normal : held.normal[i]);
    skin.tracked_area.push_back(bare ? posed.area(bound) : 0.0F);
  }
}

}  // namespace

SoftHands::SoftHands(double spacing, const SoftHandParameters& parameters)
    : parameters_(checked(spacing, parameters)), skins_(spacing, SkinKind::soft) {
  SoftHandTemplate right = makeSoftHandTemplate(Side::right, parameters.finger_cell, parameters.palm_cell);
  templates_[0] = std::make_shared<SoftHandTemplate>(mirroredTemplate(right));
  templates_[1] = std::make_shared<SoftHandTemplate>(std::move(right));
}

Skin SoftHands::update(const std::vector<TrackedHand>& hands_in_world, std::chrono::nanoseconds stamp) {
  const std::vector<TrackedHand> hands = leftThenRight(hands_in_world);
  // If the clock was set back, the loads may be of a later time.
  const bool stale =
      std::abs(seconds_a_nano * static_cast<double>((stamp - loads_stamp_).count())) > load_lifetime;
  Skin all;
  Past past{stamp, ++number_, {}, {}};
  std::array<bool, 2> seen{};
  for (const TrackedHand& hand : hands) {
    const int side = static_cast<int>(hand.side);
    seen[side] = true;
    std::optional<Present>& present = hands_[side];
    const bool goes_on = present.has_value() && !present->soft.leaps(hand);
    if (!present) {
      const double scale = handScale(hand);
      const TrackedHand rest = restHand(hand.side, scale);
      auto skin_template = skins_.of(rest);
      present.emplace(Present{SoftHand(templates_[side], skinOf(*skin_template, rest), scale, parameters_),
                              std::move(skin_template),
                              stamp,
                              number_,
                              {}});
    }
    const double dt = seconds_a_nano * static_cast<double>((stamp - present->stamp).count());
    if (!goes_on) {
      present->soft.place(hand);
      present->since = number_;
    } else if (dt > 0.0) {
      if (stale) present->soft.unload();
      present->soft.advance(hand, dt);
    }
    Skin skin;
    present->soft.appendTo(skin);
    if (goes_on && dt > 0.0)
      for (std::size_t i = 0; i < skin.size(); ++i)
        skin.velocity[i] = (skin.position[i] - present->skin.position[i]) / static_cast<float>(dt);
    past.shown[side] = samplesOfSeenJoints(skin, hand);
    const auto join = [&shown = past.shown[side]](auto& to, const auto& from) {
      for (const std::uint32_t i : shown) to.push_back(from[i]);
    };
    join(all.position, skin.position);
    join(all.normal, skin.normal);
    join(all.velocity, skin.velocity);
    join(all.area, skin.area);
    join(all.pad_distance, skin.pad_distance);
    join(all.side, skin.side);
    join(all.region, skin.region);
    appendTracked(all, skin, past.shown[side], *present->skin_template, hand);
    present->skin = std::move(skin);
    present->stamp = stamp;
    past.points[side] = present->soft.loadPoints();
  }
  for (int side = 0; side < 2; ++side)
    if (!seen[side]) hands_[side].reset();
  past_.push_back(std::move(past));
  if (past_.size() > remembered_skins) past_.pop_front();
  return all;
}

std::size_t SoftHands::react(std::chrono::nanoseconds stamp, const std::vector<SkinForce>& forces) {
  const auto past =
      std::find_if(past_.rbegin(), past_.rend(), [&](const Past& p) { return p.stamp == stamp; });
  if (past == past_.rend()) return forces.size();
  const std::size_t left = past->shown[0].size(), all = left + past->shown[1].size();
  std::array<std::vector<SkinForce>, 2> of_side;
  std::size_t dropped = 0;
  for (SkinForce f : forces) {
    if (f.index >= all || !f.force.allFinite()) {
      ++dropped;
      continue;
    }
    const int side = f.index < left ? 0 : 1;
    f.index = past->shown[side][side == 0 ? f.index : f.index - left];
    of_side[side].push_back(f);
  }
  for (int side = 0; side < 2; ++side)
    // A hand that appeared since then was not in that skin.
    if (hands_[side] && hands_[side]->since <= past->number)
      hands_[side]->soft.load(of_side[side], past->points[side]);
  loads_stamp_ = stamp;
  return dropped;
}

}  // namespace tactile_clay::hand
