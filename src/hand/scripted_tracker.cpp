#include "hand/scripted_tracker.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

#include "values/range.h"

namespace tactile_clay::hand {
namespace {

// Not std::exponential_distribution, which differs between libraries.
double exponential(std::mt19937& random, double mean) {
  return -mean * std::log((static_cast<double>(random()) + 1.0) / 4294967297.0);
}

void requireFew(std::size_t mishaps) {
  constexpr std::size_t maximum = 100000;  // of a hand; a score takes two hours at most
  if (mishaps > maximum)
    throw std::invalid_argument("scripted tracker: more than " + std::to_string(maximum) +
                                " dropouts or changes of id, expected longer intervals");
}

}  // namespace

ScriptedTracker::ScriptedTracker(TrackerScript script) : script_(std::move(script)) {
  using values::requireIn;
  requireIn("scripted tracker: rate", script_.rate, 1.0, 1000.0);
  requireIn("scripted tracker: sight", script_.sight, 0.0, 10.0);
  requireIn("scripted tracker: interval of dropouts", script_.dropout_interval, 0.0, 1e6);
  requireIn("scripted tracker: duration of dropouts", script_.dropout_duration, 0.0, 1e6);
  requireIn("scripted tracker: interval of id changes", script_.id_change_interval, 0.0, 1e6);
  requireIn("scripted tracker: noise of positions", script_.score.noise.position, 0.0, 0.1);
  requireIn("scripted tracker: noise of angles", script_.score.noise.angle, 0.0, 1.0);
  script_.score.noise.seed = script_.seed;
  const double duration = script_.score.duration();
  requireIn("scripted tracker: duration of the score (s)", duration, 0.0, longest_score);
  frames_ = static_cast<std::uint64_t>(std::floor(duration * script_.rate)) + 1;
  for (std::uint32_t side = 0; side < 2; ++side) {
    std::seed_seq seed{script_.seed, side};
    std::mt19937 random(seed);
    Mishaps& mishaps = mishaps_[side];
    // At least one frame passes between two mishaps of the same kind, whatever the interval.
    const double frame = 1.0 / script_.rate;
    if (script_.dropout_interval > 0.0)
      for (double t = 0.0; (t += frame + exponential(random, script_.dropout_interval)) < duration;) {
        const double begin = t;
        t += exponential(random, script_.dropout_duration);
        mishaps.dropouts.push_back({begin, t});
        requireFew(mishaps.dropouts.size());
        mishaps.id_changes.push_back(t);
      }
    if (script_.id_change_interval > 0.0)
      for (double t = 0.0; (t += frame + exponential(random, script_.id_change_interval)) < duration;) {
        mishaps.id_changes.push_back(t);
        requireFew(mishaps.id_changes.size());
      }
    std::sort(mishaps.id_changes.begin(), mishaps.id_changes.end());
  }
}

TrackedFrame ScriptedTracker::frame(std::uint64_t i) const {
  const double t = static_cast<double>(i) / script_.rate;
  TrackedFrame frame = script_.score.sample(t);
  frame.stamp = std::chrono::nanoseconds(std::llround(static_cast<double>(i + 1) * 1e9 / script_.rate));
  auto& hands = frame.hands;
  hands.erase(std::remove_if(hands.begin(), hands.end(),
                             [&](const TrackedHand& hand) {
                               const Eigen::Vector3d& at = hand.joints[palm].position;
                               if (at.head<2>().cwiseAbs().maxCoeff() > script_.sight) return true;
                               const auto& dropouts = mishaps_[static_cast<int>(hand.side)].dropouts;
                               const auto later = std::upper_bound(
                                   dropouts.begin(), dropouts.end(), t,
                                   [](double time, const Dropout& d) { return time < d.begin; });
                               return later != dropouts.begin() && t < std::prev(later)->end;
                             }),
              hands.end());
  for (TrackedHand& hand : hands) {
    const auto& changes = mishaps_[static_cast<int>(hand.side)].id_changes;
    const auto passed = std::upper_bound(changes.begin(), changes.end(), t) - changes.begin();
    // Left hands have odd ids, right hands even ones.
    hand.id = 2 * static_cast<std::uint32_t>(passed) + static_cast<std::uint32_t>(hand.side) + 1;
  }
  return frame;
}

}  // namespace tactile_clay::hand
