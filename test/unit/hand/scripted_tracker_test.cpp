#include "hand/scripted_tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "hand/hand_check.h"
#include "hand/hand_cleaner.h"

namespace tactile_clay::hand::scripted_tracker_test {
namespace {

TrackerScript kneading() {
  TrackerScript script;
  script.score = knead();
  script.score.noise.position = 1e-4;
  script.score.noise.angle = 1e-3;
  script.dropout_interval = 1.0;
  script.dropout_duration = 0.05;
  script.id_change_interval = 2.0;
  return script;
}

TEST(ScriptedTracker, SeesWhatIsThereAtItsRate) {
  TrackerScript script;
  script.score = pressFinger();
  script.rate = 50.0;
  const ScriptedTracker tracker(script);
  EXPECT_EQ(tracker.frames(), static_cast<std::uint64_t>(script.score.duration() * 50.0) + 1);
  for (std::uint64_t i = 0; i < tracker.frames(); ++i) {
    const TrackedFrame frame = tracker.frame(i);
    EXPECT_EQ(frame.stamp, std::chrono::milliseconds(20 * (i + 1)));
    ASSERT_EQ(frame.hands.size(), 1U);
    const TrackedFrame truth = script.score.sample(static_cast<double>(i) / 50.0);
    EXPECT_EQ(frame.hands[0].joints[index_tip].position, truth.hands[0].joints[index_tip].position);
    EXPECT_EQ(frame.hands[0].id, 2U);
  }
}

TEST(ScriptedTracker, TheSameSeedGivesTheSameSamplesAnotherOneOthers) {
  TrackerScript script = kneading();
  const ScriptedTracker first(script), again(script);
  script.seed = 2;
  const ScriptedTracker other(script);
  bool differs = false;
  for (std::uint64_t i = 0; i < first.frames(); ++i) {
    const TrackedFrame a = first.frame(i), b = again.frame(i), c = other.frame(i);
    ASSERT_EQ(a.hands.size(), b.hands.size());
    differs = differs || a.hands.size() != c.hands.size();
    for (std::size_t h = 0; h < a.hands.size(); ++h) {
      EXPECT_EQ(a.hands[h].id, b.hands[h].id);
      for (int joint = 0; joint < joint_count; ++joint)
        EXPECT_EQ(a.hands[h].joints[joint].position, b.hands[h].joints[joint].position);
    }
  }
  EXPECT_TRUE(differs);
}

// Mishaps come as often as they are asked for: in 100 s of a hand at rest, 100 dropouts (a Poisson process:
// +-30 at three sigma) of 5 s in all.
TEST(ScriptedTracker, MishapsAreAsOftenAsTheScriptSays) {
  TrackerScript script = kneading();
  const HandPose rest;
  script.score.hands = {{{0.0, rest}, {105.0, rest}}};
  script.id_change_interval = 0.0;
  const ScriptedTracker tracker(script);
  int unseen = 0, dropouts = 0;
  bool seen = true;
  std::set<std::uint32_t> ids;
  for (std::uint64_t i = 0; i < tracker.frames(); ++i) {
    const TrackedFrame frame = tracker.frame(i);
    dropouts += seen && frame.hands.empty();
    seen = !frame.hands.empty();
    unseen += !seen;
    for (const TrackedHand& hand : frame.hands) {
      ids.insert(hand.id);
      EXPECT_EQ(faultOf(hand), "");
    }
  }
  EXPECT_NEAR(dropouts, 90, 35);  // some fall between two frames
  EXPECT_NEAR(unseen / 110.0, 5.0, 2.5);
  EXPECT_GT(ids.size(), 60U);
}

TEST(ScriptedTracker, NoiseIsAsLargeAsTheScriptSays) {
  TrackerScript script;
  const HandPose rest;
  script.score.hands = {{{0.0, rest}, {20.0, rest}}};
  script.score.noise.position = 2e-4;
  const ScriptedTracker tracker(script);
  double sum = 0.0;
  for (std::uint64_t i = 0; i < tracker.frames(); ++i)
    sum += tracker.frame(i).hands.at(0).joints[wrist].position.squaredNorm() / 3.0;
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(tracker.frames())), 2e-4, 1e-5);
}

// The purpose of cleaning: changes of ids and short dropouts are bridged.
TEST(ScriptedTracker, CleanedItsHandsGoOn) {
  TrackerScript script = kneading();
  const ScriptedTracker tracker(script);
  HandCleaner cleaner(CleanConfig{});
  std::map<Side, Eigen::Vector3d> last;
  for (std::uint64_t i = 0; i < tracker.frames(); ++i) {
    TrackedFrame frame = tracker.frame(i);
    cleaner.clean(frame);
    std::map<Side, Eigen::Vector3d> now;
    for (const TrackedHand& hand : frame.hands) {
      now[hand.side] = hand.joints[palm].position;
      if (last.count(hand.side) != 0) {
        EXPECT_LT((now[hand.side] - last[hand.side]).norm(), 0.02);
      }
    }
    last = now;
  }
  EXPECT_GT(cleaner.counts().id_changes, 5U);
  EXPECT_GT(cleaner.counts().dropouts, 5U);
}

TEST(ScriptedTracker, SaysWhichNumberIsWrong) {
  TrackerScript script = kneading();
  script.rate = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ScriptedTracker{script}, std::invalid_argument);
  script = kneading();
  script.dropout_duration = -1.0;
  EXPECT_THROW(ScriptedTracker{script}, std::invalid_argument);
}

TEST(ScriptedTracker, MishapsWithoutEndAreRefused) {
  TrackerScript script = kneading();
  script.rate = 1000.0;
  script.score.hands[0].back().time = 1000.0;
  for (double* interval : {&script.dropout_interval, &script.id_change_interval}) {
    script.dropout_interval = script.id_change_interval = 0.0;
    script.dropout_duration = *interval = 1e-6;
    EXPECT_THROW(ScriptedTracker{script}, std::invalid_argument);
  }
}

}  // namespace
}  // namespace tactile_clay::hand::scripted_tracker_test
