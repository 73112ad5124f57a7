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

/// The bones of a hand as it is posed, on which the samples of a template are.
class PosedSkin {
 public:
  PosedSkin(const SkinTemplate& skin, const TrackedHand& hand);

  struct Sample {
    Eigen::Vector3f surface;  // m
    Eigen::Vector3f axis;     // m, of its bone, beneath it
    Eigen::Vector3f normal;   // outward, unit
    float radius;             // m
  };
  Sample operator()(const BoundSample& sample) const;

  /// Area that a sample stands for and its distance to a finger pad, resized with the person as the hand is
  /// seen now; m^2, m.
  float area(const BoundSample& sample) const;
  float padDistance(const BoundSample& sample) const;
  /// Bones between joints of which one is missing: they have no skin, and their samples are nowhere.
  const std::bitset<bones.size()>& absentBones() const { return absent_; }
  bool absent(const BoundSample& sample) const { return absent_[sample.bone]; }

  /// How deep a point of the bone under the sample lies in the flesh of the other bones, m; 0 where it is
  /// bare.
  double depth(const BoundSample& sample, const Eigen::Vector3f& point) const;

 private:
  struct BonePose {
    Eigen::Vector3f from, along;  // m
    float radius_from, radius_growth;
    Eigen::Matrix3f rotation;
  };
  Eigen::Vector3f normal(const BoundSample& sample) const;

  std::array<BonePose, bones.size()> poses_;
  std::array<Ball, bones.size()> balls_;                      // about the capsules
  std::array<std::bitset<bones.size()>, bones.size()> near_;  // of each bone, those whose balls meet its own
  std::array<Capsule, bones.size()> capsules_;
  std::bitset<bones.size()> absent_;
  double growth_;  // of areas
};

/// Appends a sample of a hand of `side`, with velocity zero.
/// @param sample `bound` as it is posed
void append(Skin& skin, const PosedSkin& posed, const BoundSample& bound, const PosedSkin::Sample& sample,
            Side side);

}  // namespace tactile_clay::hand
