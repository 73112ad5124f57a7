#pragma once

#include <array>
#include <bitset>
#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "hand/hand_bodies.h"
#include "hand/skin_template.h"
#include "hand/tracked_hand.h"
#include "values/skin.h"

namespace tactile_clay::hand {

/// Skin templates of the persons who are seen, by side.
class SkinTemplates {
 public:
  /// @param spacing of the samples, m
  /// @throws std::invalid_argument if `spacing` is outside 1 to 20 mm
  SkinTemplates(double spacing, SkinKind kind);

  /// The skin for a hand that appears: that of the hand before it. It is made anew if this person's size is
  /// more than a tenth off.
  std::shared_ptr<const SkinTemplate> of(const TrackedHand& hand);

 private:
  double spacing_;
  SkinKind kind_;
  std::array<std::shared_ptr<const SkinTemplate>, 2> templates_;  // by side
};

/// Skin of kinematic hands: samples follow position, length and radius of the tracked bones. While a hand
/// stays tracked its samples keep their number and order, even if the tracker rescales the person. The
/// samples of a hand that comes back are made anew if its person's size is more than a tenth off. A sample
/// that another bone covers withdraws to the axis of its own bone, where no clay is. Otherwise it would push
/// clay off the skin that covers it. Bones between missing joints have no skin.
class KinematicHands {
 public:
  /// @param spacing of the samples, m
  /// @param kind of the skin
  /// @throws std::invalid_argument if `spacing` is outside 1 to 20 mm
  explicit KinematicHands(double spacing, SkinKind kind = SkinKind::kinematic) : templates_(spacing, kind) {}

  /// Skin at the next tracker sample: the samples of the left hand, then those of the right hand, if they are
  /// present. Among two hands of one side the more confident one counts. Velocities are finite differences to
  /// the sample before. They are zero when a hand appears, when its palm leaps (`palmLeaps`), and when the
  /// stamp does not advance.
  /// @throws std::invalid_argument with the line of `faultOfNumbers` if a hand has such a fault; the state is
  /// then unchanged
  Skin update(const std::vector<TrackedHand>& hands_in_world, std::chrono::nanoseconds stamp);

 private:
  struct Tracked {
    std::shared_ptr<const SkinTemplate> skin;
    std::vector<Eigen::Vector3f> surface, axis;  // m, of each sample
    std::bitset<bones.size()> bare;              // bones without skin
    BodyPose palm;
    std::chrono::nanoseconds stamp;
  };

  void append(Skin& skin, const TrackedHand& hand, std::chrono::nanoseconds stamp);

  SkinTemplates templates_;
  // Reference for the poses of palms, by side.
  std::array<TrackedHand, 2> rest_ = {restHand(Side::left, 1.0), restHand(Side::right, 1.0)};
  std::array<std::optional<Tracked>, 2> tracked_;  // by side, while the hand is present
};

}  // namespace tactile_clay::hand
