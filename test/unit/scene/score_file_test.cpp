#include "scene/score_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>
#include <string>

#include "hand/hand_check.h"
#include "support/scratch_folder.h"

namespace tactile_clay::scene::score_file_test {
namespace {

namespace fs = std::filesystem;

class ScoreFile : public ScratchFolder {
 protected:
  hand::TrackerScript load(const std::string& text) const {
    return loadScore(write("score.yaml", text), TACTILE_CLAY_SHARE);
  }
  void expectFault(const std::string& text, const std::string& line, const std::string& words) const {
    try {
      load(text);
      ADD_FAILURE() << words << ": " << text << " is taken";
    } catch (const std::runtime_error& error) {
      const std::string fault = error.what();
      EXPECT_NE(fault.find("score.yaml:" + line), std::string::npos) << fault;
      EXPECT_NE(fault.find(words), std::string::npos) << fault;
      EXPECT_EQ(fault.find('\n'), std::string::npos) << fault;
    }
  }
};

TEST_F(ScoreFile, EveryShippedScoreIsPlayable) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(TACTILE_CLAY_SHARE "/config/hands")) {
    const std::string name = entry.path().stem().string();
    const hand::ScriptedTracker tracker(loadScore(name, TACTILE_CLAY_SHARE));
    EXPECT_GT(tracker.frames(), 200U) << name;
    std::size_t seen = 0;
    for (std::uint64_t i = 0; i < tracker.frames(); ++i)
      for (const hand::TrackedHand& one : tracker.frame(i).hands) {
        EXPECT_EQ(hand::faultOf(one), "") << name;
        ++seen;
      }
    EXPECT_GT(2 * seen, tracker.frames()) << name;
    ++count;
  }
  EXPECT_EQ(count, 6);
}

/// A score that its strokes make too long is refused before it is built.
TEST_F(ScoreFile, HasLimits) {
  expectFault("moves: [{move: knead, strokes: 1000000000}]", "1", "1 to 1000 strokes");
  expectFault("moves: [{move: pinch, times: 100000000}]", "1", "1 to 1000 times");
  expectFault("moves: [{move: roll, times: 100000000}]", "1", "1 to 1000 times");
  expectFault("moves: [{move: press_finger, speed: 1.0e-300}]", "1", "expected a score of at most 7200 s");
  expectFault("moves: [{move: press_finger, hold: 1.0e+300}]", "1", "expected a score of at most 7200 s");
  std::string many = "moves:\n";
  for (int i = 0; i < 1100; ++i) many += "  - {move: press_finger, hold: 0.1, speed: 1.0}\n";
  expectFault("pause: 0.1\n" + many, "1003", "more than 1000 moves");
  expectFault("pause: 60\n" + many, "11", "expected a score of at most 7200 s");
}

TEST_F(ScoreFile, ReadsEveryKey) {
  const hand::TrackerScript script = load(
      "{scale: 1.1, rate: 90, sight: 0.5, seed: 7, noise_position: 0.001, noise_angle: 0.01, "
      "dropout_interval: 3,\n"
      " dropout_duration: 0.05, id_change_interval: 4, pause: 0.5, moves: [\n"
      "  {move: press_finger, centre: [0.1, 0.2], block_height: 0.05, approach: 0.04, depth: 0.02, speed: "
      "0.1, hold: 1}]}");
  EXPECT_EQ(script.rate, 90.0);
  EXPECT_EQ(script.sight, 0.5);
  EXPECT_EQ(script.seed, 7U);
  EXPECT_EQ(script.score.noise.position, 0.001);
  EXPECT_EQ(script.score.noise.angle, 0.01);
  EXPECT_EQ(script.dropout_interval, 3.0);
  EXPECT_EQ(script.dropout_duration, 0.05);
  EXPECT_EQ(script.id_change_interval, 4.0);
  hand::PressFinger press;
  press.scale = 1.1;
  press.centre = {0.1, 0.2};
  press.block_height = 0.05;
  press.approach = 0.04;
  press.depth = 0.02;
  press.speed = 0.1;
  press.hold = 1.0;
  hand::Score score = script.score;
  score.noise = {};
  const hand::Score expected = hand::pressFinger(press);
  EXPECT_EQ(score.duration(), expected.duration());
  for (const double t : {0.0, 1.0, 1.5, 2.0})
    EXPECT_EQ(score.sample(t).hands[0].joints[hand::index_tip].position,
              expected.sample(t).hands[0].joints[hand::index_tip].position);
}

TEST_F(ScoreFile, ReadsEveryKeyOfAPotter) {
  const hand::Score score =
      load(
          "{scale: 1.1, moves: [{move: potter, radius: 0.052, height: 0.07, depth: 0.003, low: 0.001,\n"
          "  rise: 0.1, lean: 0.2, top: 0.069}]}")
          .score;
  hand::Potter potter;
  potter.scale = 1.1;
  potter.radius = 0.052;
  potter.height = 0.07;
  potter.depth = 0.003;
  potter.low = 0.001;
  potter.rise = 0.1;
  potter.lean = 0.2;
  potter.top = 0.069;
  const hand::Score expected = hand::potter(potter);
  EXPECT_EQ(score.duration(), expected.duration());
  for (const double t : {0.0, 4.0, 7.5, 10.0})
    EXPECT_EQ(score.sample(t).hands[0].joints[hand::thumb_tip].position,
              expected.sample(t).hands[0].joints[hand::thumb_tip].position);
}

TEST_F(ScoreFile, SaysWhatIsWrongAndWhere) {
  expectFault("moves:\n  - {move: juggle}\n", "2", "unknown move 'juggle', expected one of knead, pinch");
  expectFault("moves:\n  - {move: roll}\n  - {move: pinch, widht: 0.1}\n", "3", "unknown key 'widht'");
  expectFault("moves:\n  - {move: knead, strokes: many}\n", "2",
              "'strokes' cannot be read, expected a whole number");
  expectFault("moves:\n  - {move: knead, strokes: 0}\n", "2", "expected positive scale, 1 to 1000 strokes");
  expectFault("moves:\n  - {move: pinch, width: 0.5}\n", "2", "cannot grip");
  expectFault("moves:\n  - {move: potter, top: 0.2}\n", "2", "cannot press the top");
  expectFault("rate: 60\n", "1", "no moves");
  expectFault("rate: -1\nmoves: [{move: roll}]\n", "1", "rate: expected a number from 1 to 1000, got -1");
  expectFault("dropout_interval: .nan\nmoves: [{move: roll}]\n", "1", "'dropout_interval' is not finite");
  expectFault("scale: 9\nmoves: [{move: roll}]\n", "1", "'scale' is out of its range");
  expectFault("rait: 60\nmoves: [{move: roll}]\n", "1", "unknown key 'rait'");
  EXPECT_THROW(loadScore("nocturne", TACTILE_CLAY_SHARE), std::runtime_error);
}

}  // namespace
}  // namespace tactile_clay::scene::score_file_test
