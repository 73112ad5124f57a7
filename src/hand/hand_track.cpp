#include "hand/hand_track.h"

#include <algorithm>

#include "hand/hand_radii.h"
#include "values/seconds.h"

namespace tactile_clay::hand {
namespace {

using values::seconds;

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Factor of the radii at the end of a fade. On a thinner finger, the skins of its two sides are both in reach
// of one particle of clay, and push it about.
constexpr double thinnest_of_seen = 0.5;
constexpr double velocity_cutoff = 10.0;  // Hz, of the motion that is used for prediction
// m/s^2, maximum by which a hand speeds up or slows down: a stroke of half a metre in a sixth of a second.
constexpr double quickest_start = 100.0;

// Makes the blended and the filtered hand from the seen one.
void filter(HandTrack& track, const TrackedHand& hand, std::chrono::nanoseconds stamp,
            const CleanConfig& config) {
  const double te = seconds(stamp - track.stamp);
  double step_left = 0.0;
  if (track.steps) {
    step_left = 1.0 - seconds(stamp - track.blend_start) / config.blend;
    if (step_left <= 0.0) track.steps.reset();
  }
  const double gain = lowPassGain(velocity_cutoff, te);
  const TrackedHand before = track.clean;
  const std::bitset<joint_count> was_missing = track.seen.missing;
  track.seen = track.blended = track.clean = hand;
  for (int joint = 0; joint < joint_count; ++joint) {
    if (hand.missing[joint] || was_missing[joint]) {
      track.position[joint].reset(hand.joints[joint].position);
      track.orientation[joint].reset(hand.joints[joint].orientation);
      track.motion[joint] = {};
      continue;
    }
    JointPose& pose = track.blended.joints[joint];
    pose.orientation.normalize();
    if (track.steps) {
      pose.position -= step_left * (*track.steps)[joint].position;
      pose.orientation = pose.orientation * rotation(-step_left * (*track.steps)[joint].rotation);
    }
    JointPose& clean = track.clean.joints[joint];
    clean.position = track.position[joint].filter(pose.position, te, config.position);
    clean.orientation = track.orientation[joint].filter(pose.orientation, te, config.orientation);
    const JointPose& last = before.joints[joint];
    JointMotion& motion = track.motion[joint];
    motion.velocity += gain * ((clean.position - last.position) / te - motion.velocity);
    motion.turning +=
        gain * (rotationVector(last.orientation.conjugate() * clean.orientation) / te - motion.turning);
  }
}

}  // namespace

HandTrack startTrack(const TrackedHand& hand, std::chrono::nanoseconds stamp) {
  HandTrack track;
  track.seen = track.blended = track.clean = track.predicted = hand;
  track.stamp = track.updated = stamp;
  for (int joint = 0; joint < joint_count; ++joint) {
    track.position[joint].reset(hand.joints[joint].position);
    track.orientation[joint].reset(hand.joints[joint].orientation);
  }
  return track;
}

void goOn(HandTrack& track, const TrackedHand& hand, std::chrono::nanoseconds stamp,
          const CleanConfig& config) {
  track.velocity =
      (hand.joints[palm].position - track.seen.joints[palm].position) / seconds(stamp - track.stamp);
  filter(track, hand, stamp, config);
  track.stamp = stamp;
  // A hand that had begun to fade comes back as fast as it faded.
  track.presence =
      std::min(1.0, track.presence + seconds(stamp - track.updated) / (config.gone - config.hold));
  track.updated = stamp;
  track.shown = true;
  track.left_out.reset();
  track.predicted = track.clean;
  if (config.prediction > 0.0)
    for (int joint = 0; joint < joint_count; ++joint) {
      JointPose& pose = track.predicted.joints[joint];
      pose.position += config.prediction * track.motion[joint].velocity;
      pose.orientation = pose.orientation * rotation(config.prediction * track.motion[joint].turning);
    }
}

// A moving hand is expected where its motion takes it. So a change of id alone makes no step.
void startBlend(HandTrack& track, const TrackedHand& hand, std::chrono::nanoseconds stamp) {
  const double te = seconds(stamp - track.stamp);
  track.steps.emplace();
  track.blend_start = stamp;
  for (int joint = 0; joint < joint_count; ++joint) {
    const JointPose& to = hand.joints[joint];
    (*track.steps)[joint] = {Vector3d::Zero(), Vector3d::Zero()};
    if (hand.missing[joint] || track.seen.missing[joint]) continue;
    const JointMotion& motion = track.motion[joint];
    const Vector3d expected = track.blended.joints[joint].position + te * motion.velocity;
    const Quaterniond turned = track.blended.joints[joint].orientation * rotation(te * motion.turning);
    (*track.steps)[joint] = {to.position - expected,
                             rotationVector(turned.conjugate() * to.orientation.normalized())};
  }
}

bool isArtefact(const HandTrack& track, const TrackedHand& hand, std::chrono::nanoseconds stamp,
                const CleanConfig& config) {
  if (hand.confidence >= config.artefact_confidence) return false;
  const double te = seconds(stamp - track.stamp);
  const Vector3d& at = hand.joints[palm].position;
  const Vector3d mean = (at - track.seen.joints[palm].position) / te;
  if (mean.norm() <= config.artefact_speed) return false;
  const auto near = [&](const Vector3d& speed, double acceleration) {
    return (mean - speed).norm() <= std::max(config.artefact_speed, acceleration * te);
  };
  if (!track.left_out) return !near(track.velocity, quickest_start);
  // A mean velocity is off by half of the change of the velocity.
  const double half = 0.5 * quickest_start;
  const Vector3d now = (at - track.left_out->palm) / seconds(stamp - track.left_out->stamp);
  return !near(track.velocity, half) && !near(now, half);
}

TrackedHand faded(const HandTrack& track) {
  TrackedHand hand = track.predicted;
  if (track.presence >= 1.0) return hand;
  const double factor =
      std::max(thinnest_of_seen + (1.0 - thinnest_of_seen) * track.presence, minimumRadiusFactor(hand));
  hand.confidence *= track.presence;
  for (JointPose& joint : hand.joints) joint.radius *= factor;
  return hand;
}

}  // namespace tactile_clay::hand
