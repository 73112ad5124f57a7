#pragma once

#include <Eigen/Geometry>
#include <array>
#include <chrono>
#include <optional>

#include "hand/clean_config.h"
#include "hand/one_euro.h"
#include "hand/tracked_hand.h"

namespace tactile_clay::hand {

struct BlendStep {  // of a joint, from its expected to its seen pose
  Eigen::Vector3d position;
  Eigen::Vector3d rotation;  // rotation vector, rad
};
struct JointMotion {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s
  Eigen::Vector3d turning = Eigen::Vector3d::Zero();   // rad/s, in the joint's frame
};
struct Artefact {        // a sample that was left out
  Eigen::Vector3d palm;  // m
  std::chrono::nanoseconds stamp;
};

/// One hand over time, for HandCleaner.
struct HandTrack {
  TrackedHand seen;                  // as the tracker sent it
  TrackedHand blended;               // `seen`, without what is left of the step of a changed id
  TrackedHand clean;                 // `blended`, filtered
  TrackedHand predicted;             // `clean`, predicted
  std::chrono::nanoseconds stamp;    // when it was seen
  std::chrono::nanoseconds updated;  // when it was seen or missed
  double presence = 1.0;             // 0-1
  bool shown = true;                 // false: it jumped to its place, and was seen there only once
  /// m/s, of the palm, between the last two that were seen
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  std::optional<Artefact> left_out;  // the last artefact since `stamp`
  std::array<OneEuro<3>, joint_count> position;
  std::array<OneEuroRotation, joint_count> orientation;
  std::array<JointMotion, joint_count> motion;
  std::optional<std::array<BlendStep, joint_count>> steps;  // steps of a changed id, at blend_start
  std::chrono::nanoseconds blend_start{0};
};

/// A track that starts with a hand that was seen.
HandTrack startTrack(const TrackedHand& hand, std::chrono::nanoseconds stamp);

/// Goes on with a hand that was seen: filters and predicts it.
void goOn(HandTrack& track, const TrackedHand& hand, std::chrono::nanoseconds stamp,
          const CleanConfig& config);

/// Starts to blend the step from where the hand is expected to where a new id has it.
void startBlend(HandTrack& track, const TrackedHand& hand, std::chrono::nanoseconds stamp);

/// Whether a step of a hand is an artefact of the tracker. A hand with enough confidence is never an
/// artefact. A stroke is none either: its mean velocity since the hand was last seen agrees with the velocity
/// before, or with that after. A leap agrees with neither: it comes from rest and ends at rest.
bool isArtefact(const HandTrack& track, const TrackedHand& hand, std::chrono::nanoseconds stamp,
                const CleanConfig& config);

/// The hand of a track, as thin and unsure as its presence makes it.
TrackedHand faded(const HandTrack& track);

}  // namespace tactile_clay::hand
