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

/// Skins of the persons that are seen, by side.
class SkinTemplates {
 public:
  /// @param spacing of the samples, m
  /// @throws std::invalid_argument outside 1 to 20 mm
  SkinTemplates(double spacing, SkinKind kind);

  /// The skin for a hand that appears: that of the hand before it, or made anew where this person's size is
  /// more than a tenth off.
  std::shared_ptr<const SkinTemplate> of(const TrackedHand& hand);

 private:
  double spacing_;
  SkinKind kind_;
  std::array<std::shared_ptr<const SkinTemplate>, 2> templates_;  // by side
};

/// Skin of kinematic hands: samples follow position, length and radius of the tracked bones. While a hand
/// stays tracked its samples keep their number and order, even where the tracker rescales the person; the
/// samples of a hand that comes back are made anew if its person's size is more than a tenth off. A sample
/// that another bone covers withdraws to the axis of its own, where no clay is, or it would push clay off the
/// skin that covers it. Bones between joints that are missing have no skin.
class KinematicHands {
 public:
  /// @param spacing of the samples, m
  /// @param kind of the skin
  /// @throws std::invalid_argument outside 1 to 20 mm
  explicit KinematicHands(double spacing, SkinKind kind = SkinKind::kinematic) : templates_(spacing, kind) {}

  /// Skin at the next sample of the tracker: the left hand's samples, then the right one's, of hands that are
  /// present; of two hands of one side the more confident one. Velocities are finite differences from the
  /// sample before; zero when a hand appears, when its palm leaps (`palmLeaps`), and when the stamp does not
  /// advance.
  /// @throws std::invalid_argument with the line of `faultOfNumbers` where it has one; the state is then
  /// unchanged
  Skin update(const std::vector<TrackedHand>& hands_in_world, std::chrono::nanoseconds stamp);

 private:
  struct Tracked {
    std::shared_ptr<const SkinTemplate> skin;
    std::vector<Eigen::Vector3f> surface, axis;  // m, of the samples
    std::bitset<bones.size()> bare;              // bones without skin
    BodyPose palm;
    std::chrono::nanoseconds stamp;
  };

  void append(Skin& skin, const TrackedHand& hand, std::chrono::nanoseconds stamp);

  SkinTemplates templates_;
  // By side; what the poses of palms are told from.
  std::array<TrackedHand, 2> rest_ = {restHand(Side::left, 1.0), restHand(Side::right, 1.0)};
  std::array<std::optional<Tracked>, 2> tracked_;  // by side, while the hand is present
};

}  // namespace tactile_clay::hand
