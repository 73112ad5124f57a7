#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "hand/hand_check.h"
#include "hand/hand_cleaner.h"
#include "hand/hand_pose.h"
#include "hand/hand_sides.h"
#include "support/hand_recording.h"

namespace tactile_clay::hand::hand_cleaner_recordings_test {
namespace {

using Eigen::Vector3d;

// Real hands. Figures are printed; doc/method/hands.md has them.
struct Recorded {
  std::vector<TrackedFrame> frames;  // sane, one hand a side
};

std::optional<Recorded> recorded(const std::string& name) {
  static std::map<std::string, Recorded> known;
  if (const auto found = known.find(name); found != known.end()) return found->second;
  auto frames = recordedFrames(name);
  if (!frames) return std::nullopt;
  for (TrackedFrame& frame : *frames) {
    auto& hands = frame.hands;
    hands.erase(
        std::remove_if(hands.begin(), hands.end(), [](const auto& hand) { return !faultOf(hand).empty(); }),
        hands.end());
    keepOneHandASide(hands);
  }
  return known[name] = Recorded{*frames};
}

const TrackedHand* handOf(const TrackedFrame& frame, Side side) {
  for (const TrackedHand& hand : frame.hands)
    if (hand.side == side) return &hand;
  return nullptr;
}

/// Root mean square distance, m, of index tip and palm to where the tracker saw them `ahead` s later, over
/// hands that it saw then and now under one id.
double errorAhead(const Recorded& recorded, const CleanConfig& config, double ahead) {
  HandCleaner cleaner(config);
  double sum = 0.0;
  std::size_t count = 0, next = 0;
  for (std::size_t i = 0; i < recorded.frames.size(); ++i) {
    TrackedFrame out = recorded.frames[i];
    cleaner.clean(out);
    const double time = 1e-9 * static_cast<double>(out.stamp.count()) + ahead;
    const auto timeOf = [&](std::size_t k) {
      return 1e-9 * static_cast<double>(recorded.frames[k].stamp.count());
    };
    next = std::max(next, i);
    while (next < recorded.frames.size() && timeOf(next) < time) ++next;
    if (next >= recorded.frames.size()) break;
    const std::size_t before = next > i ? next - 1 : i;
    const double share = next > before ? (time - timeOf(before)) / (timeOf(next) - timeOf(before)) : 0.0;
    for (const TrackedHand& hand : out.hands) {
      const TrackedHand* now = handOf(recorded.frames[i], hand.side);
      const TrackedHand* a = handOf(recorded.frames[before], hand.side);
      const TrackedHand* b = handOf(recorded.frames[next], hand.side);
      if (now == nullptr || a == nullptr || b == nullptr || a->id != hand.id || b->id != hand.id) continue;
      for (const int joint : {static_cast<int>(palm), static_cast<int>(index_tip)}) {
        const Vector3d truth = (1.0 - share) * a->joints[joint].position + share * b->joints[joint].position;
        sum += (hand.joints[joint].position - truth).squaredNorm();
        ++count;
      }
    }
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

TEST(HandCleanerOnRecordings, LagAndPrediction) {
  int found = 0;
  std::printf(
      "rms error of palm and index tip, mm; lag of the filter, and error against the truth 10 and 20 ms "
      "later\n"
      "%-28s      lag lag 1 Hz |   now 10  pred 10 |   now 20  pred 20\n",
      "recording");
  for (const char* name : hand_recordings) {
    const auto hands = recorded(name);
    if (!hands) continue;
    ++found;
    const auto error = [&](double ahead, double prediction) {
      CleanConfig config;
      config.prediction = prediction;
      return 1e3 * errorAhead(*hands, config, ahead);
    };
    CleanConfig slow;
    slow.position = {1.0, 0.0, 1.0};
    const double lag = error(0.0, 0.0), slow_lag = 1e3 * errorAhead(*hands, slow, 0.0);
    const double now10 = error(0.01, 0.0), predicted10 = error(0.01, 0.01);
    const double now20 = error(0.02, 0.0), predicted20 = error(0.02, 0.02);
    std::printf("%-28s %8.3f %8.3f | ", name, lag, slow_lag);
    std::printf("%8.3f %8.3f | %8.3f %8.3f\n", now10, predicted10, now20, predicted20);
    EXPECT_LE(lag, 2.0) << name;  // 1.95 mm at three_claps, the fastest
    EXPECT_LE(predicted10, now10) << name;
    EXPECT_LE(predicted20, now20) << name;
  }
  if (found == 0) GTEST_SKIP() << "no recordings";
}

TEST(HandCleanerOnRecordings, EveryCleanHandIsSane) {
  int found = 0;
  for (const char* name : hand_recordings) {
    const auto hands = recorded(name);
    if (!hands) continue;
    ++found;
    HandCleaner cleaner(CleanConfig{});
    for (TrackedFrame frame : hands->frames) {
      cleaner.clean(frame);
      for (const TrackedHand& hand : frame.hands) ASSERT_EQ(faultOf(hand), "") << name;
    }
    const CleanCounts& n = cleaner.counts();
    std::printf("%-28s %4zu frames: dropouts %lu, losses %lu, ", name, hands->frames.size(), n.dropouts,
                n.losses);
    std::printf("id changes %lu, side changes %lu, artefacts %lu, jumps %lu\n", n.id_changes, n.side_changes,
                n.artefacts, n.jumps);
  }
  if (found == 0) GTEST_SKIP() << "no recordings";
}

}  // namespace
}  // namespace tactile_clay::hand::hand_cleaner_recordings_test
