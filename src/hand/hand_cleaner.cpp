#include "hand/hand_cleaner.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "hand/jump_check.h"

namespace tactile_clay::hand {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Factor of the radii at the end of a fade. On a thinner finger, the skins of its two sides are both in reach
// of one particle of clay, and push it about.
constexpr double thinnest = 0.5;
constexpr double velocity_cutoff = 10.0;  // Hz, of the motion that is used for prediction
// For a slow tracker: its next frame is late after this many periods. The hand is then gone in time
// for the array to be silent after 0.15 s.
constexpr double late = 1.15;
constexpr double longest_hold = 0.07, shortest_fade = 0.03;  // s
constexpr double newest_period = 0.2;                        // share of the newest period in the mean
// m/s^2, maximum by which a hand speeds up or slows down: a stroke of half a metre in a sixth of a second.
constexpr double quickest_start = 100.0;
constexpr double catching_up = 1.15;  // of the tracked palm's fastest motion: a held hand must not leap

double seconds(std::chrono::nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

void require(bool good, const char* what, double value, const char* expected) {
  if (good) return;
  std::ostringstream line;
  line << "clean tracking: " << what << " " << value << ", expected " << expected;
  throw std::invalid_argument(line.str());
}

double palmDistance(const TrackedHand& a, const TrackedHand& b) {
  return (a.joints[palm].position - b.joints[palm].position).norm();
}

TrackedHand faded(TrackedHand hand, double presence) {
  hand.confidence *= presence;
  for (JointPose& joint : hand.joints) joint.radius *= thinnest + (1.0 - thinnest) * presence;
  return hand;
}

}  // namespace

void validate(const CleanConfig& config) {
  for (const auto& [what, filter] :
       {std::pair("position", config.position), std::pair("orientation", config.orientation)}) {
    const std::string name = what;
    require(filter.min_cutoff > 0.0, (name + " min_cutoff").c_str(), filter.min_cutoff,
            "a frequency above 0 Hz");
    require(filter.beta >= 0.0, (name + " beta").c_str(), filter.beta, "0 or more");
    require(filter.derivative_cutoff > 0.0, (name + " derivative_cutoff").c_str(), filter.derivative_cutoff,
            "a frequency above 0 Hz");
  }
  require(config.hold >= 0.0 && config.hold <= 0.05, "hold", config.hold, "0 to 0.05 s");
  require(config.gone > config.hold && config.gone <= 0.15, "gone", config.gone,
          "a time after hold, to 0.15 s");
  require(config.same_hand_time >= config.gone && config.same_hand_time <= 0.15, "same_hand_time",
          config.same_hand_time, "gone to 0.15 s");
  require(config.prediction >= 0.0 && config.prediction <= max_prediction, "prediction", config.prediction,
          "0 to 0.02 s");
}

HandCleaner::HandCleaner(const CleanConfig& config) : config_(config) {
  validate(config_);
}

void HandCleaner::configure(const CleanConfig& config) {
  validate(config);
  config_ = config;
}

void HandCleaner::clean(TrackedFrame& frame) {
  if (last_frame_) {
    const double te = seconds(frame.stamp - *last_frame_);
    if (te < config_.same_hand_time) period_ += newest_period * (te - period_);
  }
  last_frame_ = frame.stamp;
  update(frame);
}

void HandCleaner::hold(TrackedFrame& frame) {
  frame.hands.clear();
  update(frame);
}

void HandCleaner::update(TrackedFrame& frame) {
  const std::array<const TrackedHand*, 2> seen = {choose(frame, Side::left), choose(frame, Side::right)};
  for (int side = 0; side < 2; ++side) {
    std::optional<Track>& track = tracks_[side];
    const TrackedHand* other = seen[1 - side];
    if (track && !seen[side] && other && other->id == track->seen.id &&
        palmDistance(*other, track->seen) <= config_.same_hand_distance) {
      track.reset();
      ++counts_.side_changes;
    }
  }
  std::vector<TrackedHand> hands;
  for (int side = 0; side < 2; ++side) {
    std::optional<Track>& track = tracks_[side];
    if (seen[side])
      see(track, *seen[side], frame.stamp);
    else
      miss(track, frame.stamp);
    if (track && track->shown && track->presence > 0.0)
      hands.push_back(faded(track->released, track->presence));
  }
  frame.hands = std::move(hands);
}

const TrackedHand* HandCleaner::choose(const TrackedFrame& frame, Side side) {
  const std::optional<Track>& track = tracks_[static_cast<int>(side)];
  const auto better = [&](const TrackedHand& a, const TrackedHand& b) {
    if (!track) return a.confidence > b.confidence;
    const bool same_a = a.id == track->seen.id, same_b = b.id == track->seen.id;
    return same_a != same_b ? same_a : palmDistance(a, track->seen) < palmDistance(b, track->seen);
  };
  const TrackedHand* best = nullptr;
  for (const TrackedHand& hand : frame.hands) {
    if (hand.side != side) continue;
    if (best) ++counts_.doubles;
    if (!best || better(hand, *best)) best = &hand;
  }
  return best;
}

void HandCleaner::see(std::optional<Track>& track, const TrackedHand& hand, std::chrono::nanoseconds stamp) {
  forget(track, stamp);
  bool jumped = false;
  if (track) {
    if (isArtefact(*track, hand, stamp)) {
      ++counts_.artefacts;
      miss(track, stamp);
      track->left_out = {hand.joints[palm].position, stamp};
      return;
    }
    const bool renamed = hand.id != track->seen.id;
    if (palmJumps(track->seen, hand, seconds(stamp - track->stamp)) ||
        (renamed && palmDistance(hand, track->seen) > config_.same_hand_distance)) {
      ++counts_.jumps;
      jumped = true;
      track.reset();
    } else {
      if (renamed) {
        startBlend(*track, hand, stamp);
        ++counts_.id_changes;
      }
      return goOn(*track, hand, stamp);
    }
  }
  track = Track();
  track->seen = track->blended = track->clean = track->released = hand;
  track->stamp = track->updated = stamp;
  track->shown = !jumped;
  for (int joint = 0; joint < joint_count; ++joint) {
    track->position[joint].reset(hand.joints[joint].position);
    track->orientation[joint].reset(hand.joints[joint].orientation);
  }
}

// A hand with enough confidence is never an artefact. A stroke is none either: its mean velocity since the
// hand was last seen agrees with the velocity before, or with that after. A leap agrees with neither: it
// comes from rest and ends at rest.
bool HandCleaner::isArtefact(const Track& track, const TrackedHand& hand,
                             std::chrono::nanoseconds stamp) const {
  if (hand.confidence >= config_.artefact_confidence) return false;
  const double te = seconds(stamp - track.stamp);
  const Vector3d& at = hand.joints[palm].position;
  const Vector3d mean = (at - track.seen.joints[palm].position) / te;
  if (mean.norm() <= config_.artefact_speed) return false;
  const auto near = [&](const Vector3d& speed, double acceleration) {
    return (mean - speed).norm() <= std::max(config_.artefact_speed, acceleration * te);
  };
  if (!track.left_out) return !near(track.velocity, quickest_start);
  // A mean velocity is off by half of the change of the velocity.
  const double half = 0.5 * quickest_start;
  const Vector3d now = (at - track.left_out->palm) / seconds(stamp - track.left_out->stamp);
  return !near(track.velocity, half) && !near(now, half);
}

// A moving hand is expected where its motion takes it. So a change of id alone makes no step.
void HandCleaner::startBlend(Track& track, const TrackedHand& hand, std::chrono::nanoseconds stamp) {
  const double te = seconds(stamp - track.stamp);
  track.steps.emplace();
  track.blend_start = stamp;
  for (int joint = 0; joint < joint_count; ++joint) {
    const JointPose& to = hand.joints[joint];
    (*track.steps)[joint] = {Vector3d::Zero(), Vector3d::Zero()};
    if (hand.missing[joint] || track.seen.missing[joint]) continue;
    const Motion& motion = track.motion[joint];
    const Vector3d expected = track.blended.joints[joint].position + te * motion.velocity;
    const Quaterniond turned = track.blended.joints[joint].orientation * rotation(te * motion.turning);
    (*track.steps)[joint] = {to.position - expected,
                             rotationVector(turned.conjugate() * to.orientation.normalized())};
  }
}

void HandCleaner::goOn(Track& track, const TrackedHand& hand, std::chrono::nanoseconds stamp) {
  const Vector3d raw_step = hand.joints[palm].position - track.seen.joints[palm].position;
  const Vector3d released = track.clean.joints[palm].position;
  filter(track, hand, stamp);
  track.velocity = raw_step / seconds(stamp - track.stamp);
  track.fastest = std::max(track.fastest, track.velocity.norm());
  const Vector3d step = track.clean.joints[palm].position - released;
  const double farthest = catching_up * track.fastest * seconds(stamp - track.updated);
  if (step.norm() > farthest)
    for (JointPose& joint : track.clean.joints) joint.position += (farthest / step.norm() - 1.0) * step;
  track.stamp = stamp;
  // A hand that had begun to fade comes back as fast as it faded.
  track.presence =
      std::min(1.0, track.presence + seconds(stamp - track.updated) / (config_.gone - config_.hold));
  track.updated = stamp;
  track.shown = true;
  track.left_out.reset();
  track.released = track.clean;
  if (config_.prediction > 0.0)
    for (int joint = 0; joint < joint_count; ++joint) {
      JointPose& pose = track.released.joints[joint];
      pose.position += config_.prediction * track.motion[joint].velocity;
      pose.orientation = pose.orientation * rotation(config_.prediction * track.motion[joint].turning);
    }
}

// Makes the blended and the filtered hand from the seen one.
void HandCleaner::filter(Track& track, const TrackedHand& hand, std::chrono::nanoseconds stamp) {
  const double te = seconds(stamp - track.stamp);
  double step_left = 0.0;
  if (track.steps) {
    step_left = 1.0 - seconds(stamp - track.blend_start) / config_.blend;
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
    clean.position = track.position[joint].filter(pose.position, te, config_.position);
    clean.orientation = track.orientation[joint].filter(pose.orientation, te, config_.orientation);
    const JointPose& last = before.joints[joint];
    Motion& motion = track.motion[joint];
    motion.velocity += gain * ((clean.position - last.position) / te - motion.velocity);
    motion.turning +=
        gain * (rotationVector(last.orientation.conjugate() * clean.orientation) / te - motion.turning);
  }
}

void HandCleaner::miss(std::optional<Track>& track, std::chrono::nanoseconds stamp) {
  forget(track, stamp);
  if (!track) return;
  if (track->presence > 0.0) ++counts_.dropouts;
  const double age = seconds(stamp - track->stamp);
  const double hold = std::max(config_.hold, std::min(late * period_, longest_hold));
  const double gone = std::max(config_.gone, hold + shortest_fade);
  const double left = (gone - age) / (gone - hold);
  track->presence = std::max(0.0, std::min(track->presence, left));
  track->updated = stamp;
}

void HandCleaner::forget(std::optional<Track>& track, std::chrono::nanoseconds stamp) {
  if (!track || seconds(stamp - track->stamp) < config_.same_hand_time) return;
  track.reset();
  ++counts_.losses;
}

}  // namespace tactile_clay::hand
