#include "tools/hand_samples.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <utility>

#include "hand/choreography.h"
#include "hand/hand_check.h"
#include "hand/kinematic_hand.h"
#include "hand/leap_recording.h"
#include "scene/score_file.h"
#include "tools/rig_pose.h"

namespace tactile_clay::tools {

namespace {

constexpr double frame = 1.0 / 60.0;            // s
constexpr double duration_without_hands = 1.2;  // s

std::chrono::nanoseconds nanoseconds(double seconds) {
  return std::chrono::nanoseconds(std::llround(seconds * 1e9));
}

HandSample sampleOf(double duration, std::vector<hand::TrackedHand> hands, std::chrono::nanoseconds stamp,
                    hand::KinematicHands& model) {
  Skin skin = model.update(hands, stamp);
  return {duration, std::move(skin), std::move(hands), stamp};
}

std::vector<HandSample> withoutHands(double duration) {
  return std::vector<HandSample>(static_cast<std::size_t>(std::lround(duration / frame)), {frame, {}});
}

std::vector<HandSample> played(const hand::Score& score, double duration, double spacing) {
  hand::KinematicHands hands(spacing);
  std::vector<HandSample> samples;
  const int count = static_cast<int>(std::lround((duration > 0.0 ? duration : score.duration()) / frame));
  for (int k = 1; k <= count; ++k) {
    const double t = k * frame;
    samples.push_back(sampleOf(frame, score.sample(t).hands, nanoseconds(t), hands));
  }
  return samples;
}

/// The hands without errors, in the world.
std::vector<hand::TrackedHand> usable(std::vector<hand::TrackedHand> seen, const Eigen::Isometry3d& tracker) {
  hand::leaveOutBadHands(seen);
  for (hand::TrackedHand& h : seen) {
    for (hand::JointPose& joint : h.joints) {
      joint.position = tracker * joint.position;
      joint.orientation = Eigen::Quaterniond(tracker.rotation()) * joint.orientation;
    }
  }
  return seen;
}

std::vector<HandSample> recorded(const std::string& file, double duration, double spacing,
                                 const Eigen::Isometry3d& tracker) {
  hand::LeapRecording recording;
  hand::SourceOptions source;
  source.file = file;
  recording.open(source);
  hand::KinematicHands hands(spacing);
  std::vector<HandSample> samples;
  hand::TrackedFrame seen;
  std::optional<std::chrono::nanoseconds> before;
  double time = 0.0;
  while (recording.read(seen, {}) == hand::HandSource::Read::frame) {
    const auto passed = before ? seen.stamp - *before : nanoseconds(frame);
    before = seen.stamp;
    // Stamps may have a long gap, which need not be played in full, or go back.
    const double sample_duration = std::clamp(std::chrono::duration<double>(passed).count(), 0.0, 1.0);
    time += sample_duration;
    if (duration > 0.0 && time > duration) break;
    samples.push_back(sampleOf(sample_duration, usable(seen.hands, tracker), seen.stamp, hands));
  }
  return samples;
}

}  // namespace

std::vector<HandSample> handSamples(const std::string& hands, double duration, double spacing,
                                    const std::string& share) {
  if (hands == "none") return withoutHands(duration > 0.0 ? duration : duration_without_hands);
  if (hands == "knead") return played(hand::knead(), duration, spacing);
  if (hands == "potter") return played(hand::potter(), duration, spacing);
  if (hands == "press") return played(hand::pressFinger(), duration, spacing);
  if (scene::isScore(hands, share)) return played(scene::loadScore(hands, share).score, duration, spacing);
  if (!std::filesystem::is_regular_file(hands))
    throw std::runtime_error(
        "--hands '" + hands +
        "': expected none, knead, potter, press, a score of config/hands, its YAML file, or a "
        "readable Leap recording");
  return recorded(hands, duration, spacing, rigPose(share, "tracker_pose"));
}

}  // namespace tactile_clay::tools
