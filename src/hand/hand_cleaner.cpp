#include "hand/hand_cleaner.h"

#include <algorithm>
#include <utility>

#include "hand/jump_check.h"
#include "values/seconds.h"

namespace tactile_clay::hand {
namespace {

using values::seconds;

// For a slow tracker: its next frame is late after this many periods. The hand is then gone in time
// for the array to be silent after 0.15 s.
constexpr double late_after = 1.15;
constexpr double longest_hold = 0.07, shortest_fade = 0.03;  // s
constexpr double newest_period = 0.2;                        // share of the newest period in the mean

double palmDistance(const TrackedHand& a, const TrackedHand& b) {
  return (a.joints[palm].position - b.joints[palm].position).norm();
}

}  // namespace

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
    std::optional<HandTrack>& track = tracks_[side];
    const TrackedHand* other = seen[1 - side];
    if (track && !seen[side] && other && other->id == track->seen.id &&
        palmDistance(*other, track->seen) <= config_.same_hand_distance) {
      track.reset();
      ++counts_.side_changes;
    }
  }
  std::vector<TrackedHand> hands;
  for (int side = 0; side < 2; ++side) {
    std::optional<HandTrack>& track = tracks_[side];
    if (seen[side])
      see(track, *seen[side], frame.stamp);
    else
      miss(track, frame.stamp);
    std::optional<TrackedHand> goal;
    if (track && track->shown && track->presence > 0.0) goal = faded(*track);
    const bool is_seen = track && track->stamp == frame.stamp;
    auto shown = limits_[side].step(is_seen ? &track->seen : nullptr, goal ? &*goal : nullptr, frame.stamp);
    if (shown) hands.push_back(*shown);
  }
  frame.hands = std::move(hands);
}

const TrackedHand* HandCleaner::choose(const TrackedFrame& frame, Side side) {
  const std::optional<HandTrack>& track = tracks_[static_cast<int>(side)];
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

void HandCleaner::see(std::optional<HandTrack>& track, const TrackedHand& hand,
                      std::chrono::nanoseconds stamp) {
  forget(track, stamp);
  bool jumped = false;
  if (track) {
    if (isArtefact(*track, hand, stamp, config_)) {
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
      limits_[static_cast<int>(hand.side)].forget();
    } else {
      if (renamed) {
        startBlend(*track, hand, stamp);
        ++counts_.id_changes;
      }
      return goOn(*track, hand, stamp, config_);
    }
  }
  track = startTrack(hand, stamp);
  track->shown = !jumped;
}

void HandCleaner::miss(std::optional<HandTrack>& track, std::chrono::nanoseconds stamp) {
  forget(track, stamp);
  if (!track) return;
  if (track->presence > 0.0) ++counts_.dropouts;
  const double age = seconds(stamp - track->stamp);
  const double hold = std::max(config_.hold, std::min(late_after * period_, longest_hold));
  const double gone = std::max(config_.gone, hold + shortest_fade);
  const double left = (gone - age) / (gone - hold);
  track->presence = std::max(0.0, std::min(track->presence, left));
  track->updated = stamp;
}

void HandCleaner::forget(std::optional<HandTrack>& track, std::chrono::nanoseconds stamp) {
  if (!track || seconds(stamp - track->stamp) < config_.same_hand_time) return;
  track.reset();
  ++counts_.losses;
}

}  // namespace tactile_clay::hand
