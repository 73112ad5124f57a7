#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <cstddef>

#include "hand/capsule.h"
#include "hand/hand_shape.h"
#include "hand/skin_template.h"
#include "hand/tracked_hand.h"
#include "values/skin.h"

namespace tactile_clay::hand {

/// m beneath the skin of other bones, up to which a sample still counts as on the skin of the hand.
inline constexpr double bare_within = 1e-3;

/// The samples of a template on the bones of a hand as it is posed. Refers to the template.
class PosedSkin {
 public:
  PosedSkin(const SkinTemplate& skin, const TrackedHand& hand);

  struct Sample {
    Eigen::Vector3f surface;  // m
    Eigen::Vector3f axis;     // m, of its bone, beneath it
    Eigen::Vector3f normal;   // outward, unit
    float radius;             // m
  };
  Sample operator[](std::size_t i) const;
  std::size_t size() const { return skin_->samples.size(); }

  /// Area that a sample stands for and its distance to a finger pad, resized with the person as the hand is
  /// seen now; m^2, m.
  float area(std::size_t i) const;
  float padDistance(std::size_t i) const;
  /// Bones between joints of which one is missing: they have no skin, and their samples are nowhere.
  const std::bitset<bones.size()>& absentBones() const { return absent_; }
  bool absent(std::size_t i) const { return absent_[skin_->samples[i].bone]; }
  Joint region(std::size_t i) const { return bones[skin_->samples[i].bone].region; }

  /// How deep a point of the bone under sample i lies in the flesh of the other bones, m; 0 where it is bare.
  double depth(std::size_t i, const Eigen::Vector3f& point) const;

 private:
  struct BonePose {
    Eigen::Vector3f from, along;  // m
    float radius_from, radius_growth;
    Eigen::Matrix3f rotation;
  };
  Eigen::Vector3f normal(const BoundSample& sample) const;

  const SkinTemplate* skin_;
  std::array<BonePose, bones.size()> poses_;
  std::array<Ball, bones.size()> balls_;                      // about the capsules
  std::array<std::bitset<bones.size()>, bones.size()> near_;  // of each bone, those whose balls meet its own
  std::array<Capsule, bones.size()> capsules_;
  std::bitset<bones.size()> absent_;
  double growth_;  // of areas
};

/// Appends sample i of a hand of `side`, with velocity zero.
void append(Skin& skin, const PosedSkin& posed, std::size_t i, const PosedSkin::Sample& sample, Side side);

}  // namespace tactile_clay::hand
