#include "tools/hand_samples.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "hand/choreography.h"
#include "support/scratch_folder.h"

namespace tactile_clay::tools::hand_samples_test {
namespace {

constexpr double frame = 1.0 / 60.0;  // s
constexpr double spacing = 0.016;     // m

std::vector<HandSample> samplesOf(const std::string& hands, double duration) {
  return handSamples(hands, duration, spacing, TACTILE_CLAY_SHARE);
}

std::vector<double> durations(const std::vector<HandSample>& samples) {
  std::vector<double> all;
  for (const HandSample& sample : samples) all.push_back(sample.duration);
  return all;
}

TEST(HandSamples, WithoutHandsAreFramesWithoutSkin) {
  EXPECT_EQ(durations(samplesOf("none", 0.0)), std::vector<double>(72, frame));  // 1.2 s
  const std::vector<HandSample> samples = samplesOf("none", 0.5);
  EXPECT_EQ(durations(samples), std::vector<double>(30, frame));
  for (const HandSample& sample : samples) EXPECT_EQ(sample.skin.size(), 0U);
}

TEST(HandSamples, OfAScoreLastAsItDoesOrAsLongAsWanted) {
  const double whole = hand::pressFinger().duration();
  EXPECT_EQ(static_cast<long>(samplesOf("press", 0.0).size()), std::lround(whole / frame));
  EXPECT_EQ(durations(samplesOf("press", 0.5)), std::vector<double>(30, frame));
}

TEST(HandSamples, OfAScoreAreItsSkinAtTheEndOfEachFrame) {
  const std::vector<HandSample> samples = samplesOf("press", 1.0);
  const auto lowest = [](const std::vector<Eigen::Vector3f>& points) {
    float z = INFINITY;
    for (const Eigen::Vector3f& p : points) z = std::min(z, p.z());
    return z;
  };
  for (std::size_t k = 0; k < samples.size(); ++k) {
    EXPECT_GT(samples[k].skin.size(), 0U);
    EXPECT_EQ(samples[k].skin.side, std::vector<std::uint8_t>(samples[k].skin.size(), 1))
        << "the right finger";
    if (k == 0) continue;
    // Each moved to where it is by its velocity over the frame.
    const Eigen::Vector3f moved = samples[k].skin.position[0] - samples[k - 1].skin.position[0];
    EXPECT_LT((moved - static_cast<float>(frame) * samples[k].skin.velocity[0]).norm(), 1e-6f) << k;
  }
  EXPECT_LT(lowest(samples.back().skin.position), lowest(samples.front().skin.position)) << "it goes down";
}

class RecordedHands : public ScratchFolder {
 protected:
  void SetUp() override {
    ScratchFolder::SetUp();
    std::string frames;
    for (const int microseconds : {1000000, 1020000, 1050000, 6050000})
      frames += R"({"id":1,"timestamp":)" + std::to_string(microseconds) +
                R"(,"hands":[],"pointables":[]})"
                "\n";
    file = write("recording.ndjson", frames);
  }

  std::string file;
};

TEST_F(RecordedHands, LastFromStampToStampAndAtMostASecond) {
  const std::vector<double> all = durations(samplesOf(file, 0.0));
  ASSERT_EQ(all.size(), 4U);
  EXPECT_NEAR(all[0], frame, 1e-9);  // nothing is before it
  EXPECT_NEAR(all[1], 0.02, 1e-9);
  EXPECT_NEAR(all[2], 0.03, 1e-9);
  EXPECT_EQ(all[3], 1.0);
}

TEST_F(RecordedHands, EndWhereTheWantedTimeDoes) {
  EXPECT_EQ(samplesOf(file, 0.05).size(), 2U);  // 17 and 20 ms; 30 more would be too long
}

TEST_F(RecordedHands, ThatAreNoFileSayWhatWasExpected) {
  try {
    samplesOf((folder / "nobody").string(), 0.0);
    FAIL() << "no exception";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("nobody': expected none, knead, potter, press, a score"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace tactile_clay::tools::hand_samples_test
